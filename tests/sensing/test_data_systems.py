"""The named data systems, any other rates, and the numbers that the noise is derived from."""

from dataclasses import replace

import pytest

from pitotbench import BadInputError, air
from pitotbench.records.case import DataSystem
from pitotbench.sensing.sampling import SYSTEMS, data_system, has_velocity_down, require_rates
from pitotbench.units import INCH_OF_MERCURY, KNOT, PSI


def test_only_the_high_end_gives_velocity_down_unless_a_system_states_it():
    """Martos et al. (2011), II.C; the receiver alone is noisier."""
    assert [data_system(name).label for name in SYSTEMS] == list(SYSTEMS)
    assert [has_velocity_down(SYSTEMS[name]) for name in ("20/1", "50/50", "100/100")] == [False, True, True]
    for stated in ("recorded", "missing"):
        systems = [replace(system, vertical_velocity=stated) for system in SYSTEMS.values()]
        assert {has_velocity_down(system) for system in systems} == {stated == "recorded"}
    assert SYSTEMS["20/1"].velocity_noise > SYSTEMS["50/50"].velocity_noise == SYSTEMS["100/100"].velocity_noise


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
        *((text, KNOWN) for text in ("", "20", "20/", "fast/slow", "20/1/1", "-20/1", "20/-1", "1e2/1", "nan/1")),
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
