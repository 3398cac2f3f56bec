"""The named data systems, any other rates, and the numbers that the noise is derived from."""

from dataclasses import replace

import pytest

from pitotbench import BadInputError, air
from pitotbench.records.case import DataSystem
from pitotbench.sensing.sampling import SYSTEMS, data_system, has_velocity_down, require_rates
from pitotbench.units import INCH_OF_MERCURY, KNOT, PSI


@pytest.mark.parametrize("name", list(SYSTEMS))
def test_a_named_system_has_the_rates_of_its_name(name):
    assert data_system(name).label == name


def test_only_the_high_end_gives_velocity_down():
    """Martos et al. (2011), II.C."""
    assert [has_velocity_down(SYSTEMS[name]) for name in ("20/1", "50/50", "100/100")] == [False, True, True]


@pytest.mark.parametrize(("stated", "recorded"), [("recorded", True), ("missing", False)])
def test_a_system_may_state_whether_it_records_velocity_down(stated, recorded):
    assert all(has_velocity_down(replace(SYSTEMS[n], vertical_velocity=stated)) == recorded for n in SYSTEMS)


def test_the_receiver_alone_is_noisier():
    assert SYSTEMS["20/1"].velocity_noise > SYSTEMS["50/50"].velocity_noise == SYSTEMS["100/100"].velocity_noise


def test_noise_is_ten_times_the_specification():
    """0.026 % of full scale is 3σ of the instrument; the source injects an order of magnitude more."""
    das = DataSystem()
    assert das.impact_pressure_range == pytest.approx(2.0 * PSI, rel=1e-5)
    specified = 0.026e-2 * das.impact_pressure_range / 3.0
    assert das.impact_pressure_noise / specified == pytest.approx(10.0, abs=0.1)
    static = 0.026e-2 * 38.0 * INCH_OF_MERCURY / 3.0
    assert das.static_pressure_noise / static == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize(("knots", "noise_kt"), [(100.0, 0.36), (160.0, 0.22)])
def test_noise_in_knots(knots, noise_kt):
    slope = air.calibrated_airspeed_slope(air.impact_pressure(knots * KNOT)) / KNOT
    assert slope * DataSystem().impact_pressure_noise == pytest.approx(noise_kt, abs=0.006)


@pytest.mark.parametrize(
    ("text", "air_rate", "gps_rate"), [("25/5", 25, 5), ("33.3/7", 33.3, 7), (" 10 / 10 ", 10, 10)]
)
def test_any_rates(text, air_rate, gps_rate):
    system = data_system(text)
    assert (system.air_rate, system.gps_rate) == (air_rate, gps_rate)


@pytest.mark.parametrize("text", ["", "20", "20/", "fast/slow", "20/1/1", "-20/1", "20/-1", "1e2/1", "nan/1"])
def test_nonsense_is_answered_with_the_known(text):
    with pytest.raises(BadInputError, match=r"unknown data system .*Known: 20/1, 50/50, 100/100.*such as 25/5"):
        data_system(text)


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        ("1/20", "must be above 0 and not exceed the air-data rate; write air data first"),
        ("0/0", "must be above 0"),
        ("20/0", "must be above 0"),
        ("200/1", "must not exceed the 100 Hz"),
    ],
)
def test_rates_that_cannot_be(text, rule):
    with pytest.raises(BadInputError, match=rule):
        data_system(text)


def test_a_slow_flight_cannot_be_sensed_fast():
    with pytest.raises(BadInputError, match="50 Hz"):
        require_rates(data_system("100/100"), 50.0)
