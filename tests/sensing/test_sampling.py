"""Data systems and their instants: on the samples where rates allow, between them where not, never
across a gap.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitotbench import BadInputError, air
from pitotbench.records.case import DataSystem
from pitotbench.sensing.sampling import (
    SYSTEMS,
    data_system,
    flight_rate,
    has_velocity_down,
    require_rates,
    schedule,
)
from pitotbench.units import INCH_OF_MERCURY, KNOT, PSI

TIME = 5.0 + np.arange(1001) / 100.0
GAPPED = np.where(np.arange(1001) < 400, TIME, TIME + 12.34)


def test_flight_rate_ignores_gaps():
    assert flight_rate(GAPPED) == pytest.approx(100.0)


@pytest.mark.parametrize(("air", "gps"), [(100, 100), (50, 50), (50, 10), (20, 1), (100, 1)])
def test_whole_ratios_fall_on_samples(air, gps):
    when = schedule(TIME, air, gps)
    assert not when.rows.weight.any()
    np.testing.assert_allclose(when.rows.of(TIME), when.time, atol=1e-12)
    np.testing.assert_allclose(np.diff(when.time), 1.0 / air, rtol=1e-6)
    assert when.fresh.sum() == len(when.gps.below) == 10 * gps + 1
    held = when.gps.of(TIME)[when.fix]
    assert np.all((when.time - held > -1e-9) & (when.time - held < 1.0 / gps - 0.5 / air))


@given(st.floats(1.5, 100.0), st.floats(0.01, 1.0))
def test_any_ratio(air, share):
    """A linear channel is interpolated exactly; each row holds the latest fix and none of the
    future.
    """
    when = schedule(TIME, air, air * share)
    np.testing.assert_allclose(when.rows.of(TIME), when.time, atol=1e-6)
    age = when.time - when.gps.of(TIME)[when.fix]
    assert age.min() > -1e-6
    assert age.max() < 1.0 / (air * share) + 1e-6
    assert when.fresh[0]
    np.testing.assert_array_equal(when.fresh[1:], np.diff(when.fix) > 0)


def test_a_gap_is_not_bridged():
    when = schedule(GAPPED, 20.0, 1.0)
    inside = (when.time <= GAPPED[399]) | (when.time >= GAPPED[400])
    assert inside.all()
    first = int(np.searchsorted(when.time, GAPPED[400]))
    assert when.time[first] == GAPPED[400]
    assert when.fresh[first]
    assert when.gps.of(GAPPED)[when.fix][first] == GAPPED[400]


def test_latency_shows_the_past():
    when = schedule(TIME, 50.0, 50.0, air_latency=0.125, gps_latency=0.5)
    late = when.time > TIME[0] + 0.5
    np.testing.assert_allclose((when.time - when.air.of(TIME))[late], 0.125, atol=1e-9)
    np.testing.assert_allclose((when.time - when.gps.of(TIME)[when.fix])[late], 0.5, atol=1e-9)
    assert when.air.of(TIME)[0] == TIME[0]


def test_only_the_high_end_gives_velocity_down_unless_a_system_states_it():
    """Martos et al. (2011), II.C; the receiver alone is noisier."""
    assert [data_system(name).label for name in SYSTEMS] == list(SYSTEMS)
    assert [has_velocity_down(SYSTEMS[name]) for name in ("20/1", "50/50", "100/100")] == [
        False,
        True,
        True,
    ]
    for stated in ("recorded", "missing"):
        systems = [replace(system, vertical_velocity=stated) for system in SYSTEMS.values()]
        assert {has_velocity_down(system) for system in systems} == {stated == "recorded"}
    assert (
        SYSTEMS["20/1"].velocity_noise
        > SYSTEMS["50/50"].velocity_noise
        == SYSTEMS["100/100"].velocity_noise
    )


def test_noise_is_ten_times_the_specification():
    """0.026 % of full scale is 3σ of the instrument; the source injects an order of magnitude more."""
    das = DataSystem()
    assert das.impact_pressure_range == pytest.approx(2.0 * PSI, rel=1e-5)
    specified = 0.026e-2 * das.impact_pressure_range / 3.0
    assert das.impact_pressure_noise / specified == pytest.approx(10.0, abs=0.1)
    static = 0.026e-2 * 38.0 * INCH_OF_MERCURY / 3.0
    assert das.static_pressure_noise / static == pytest.approx(1.0, abs=0.15)
    for knots, noise_kt in ((100.0, 0.36), (160.0, 0.22)):
        slope = air.calibrated_airspeed_slope(air.impact_pressure(knots * KNOT)) / KNOT
        assert slope * das.impact_pressure_noise == pytest.approx(noise_kt, abs=0.006)


@pytest.mark.parametrize(
    ("text", "air_rate", "gps_rate"), [("25/5", 25, 5), ("33.3/7", 33.3, 7), (" 10 / 10 ", 10, 10)]
)
def test_any_rates(text, air_rate, gps_rate):
    system = data_system(text)
    assert (system.air_rate, system.gps_rate) == (air_rate, gps_rate)


KNOWN = r"unknown data system .*Known: 20/1, 50/50, 100/100.*such as 25/5"


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        *(
            (text, KNOWN)
            for text in ("", "20", "20/", "fast/slow", "20/1/1", "-20/1", "20/-1", "1e2/1", "nan/1")
        ),
        ("1/20", "must be above 0 and not exceed the air-data rate; write air data first"),
        ("0/0", "must be above 0"),
        ("20/0", "must be above 0"),
        ("200/1", "must not exceed the 100 Hz"),
    ],
)
def test_rates_that_cannot_be_are_answered_with_the_rule_or_the_known(text, rule):
    with pytest.raises(BadInputError, match=rule):
        data_system(text)
    with pytest.raises(BadInputError, match="50 Hz"):
        require_rates(data_system("100/100"), 50.0)
