"""A wind that is stated is a prior of the wind: the car on a calm road."""

import numpy as np
import pytest
from tests.shared_data import shared_case

from pitotbench import BadInputError, calibrate, read_log
from pitotbench.calibration.options import CalibrationOptions, stated_wind
from pitotbench.units import KNOT


@pytest.mark.parametrize(
    ("text", "north", "east", "two_sigma"),
    [
        ("0", 0.0, 0.0, 2.0),
        ("8@270", 0.0, 8.0, 2.0),
        ("8±1@180", 8.0, 0.0, 1.0),
        ("8/1@90", 0.0, -8.0, 1.0),
    ],
)
def test_a_wind_is_read_in_knots_and_degrees(text, north, east, two_sigma):
    found = stated_wind(text)
    expected = (north * KNOT, east * KNOT, 0.5 * two_sigma * KNOT)
    assert (found.north, found.east, found.deviation) == pytest.approx(expected, abs=1e-9)


def test_a_name_is_no_stated_wind():
    assert stated_wind("checked") is None
    for text, words in (("8", "8@250"), ("8±0@250", "above zero"), ("calm", "Or state it: 0")):
        with pytest.raises(BadInputError, match=words):
            CalibrationOptions(wind=text)


def test_a_calm_day_halves_the_bound_of_a_car():
    """Out and back on a road: the airspeed is 16 % low, the wind across the road is unknown."""
    log = read_log(shared_case("32-car-on-a-road.csv.gz"))
    found, free = calibrate(log, wind="0"), calibrate(log)
    curve = found.curve
    off = curve.correction - (1.0 / 0.84 - 1.0) * curve.indicated_airspeed
    assert np.all(np.abs(off) <= curve.two_sigma)
    assert np.median(curve.two_sigma) < 0.7 * np.median(free.curve.two_sigma)
    assert found.wind.east.two_sigma < 2.1 * KNOT < free.wind.east.two_sigma
    assert any(a.name == "wind_kt" and a.two_sigma == pytest.approx(2.0) for a in found.assumptions)
    assert not found.one_sided
