"""The vector form: attitude and flow angles tell the wind across the path, and so the curve on few headings."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import bench
from pitotbench.calibrate import CalibrationOptions, calibrate
from pitotbench.records.case import Case, Wind
from pitotbench.records.errors import BadInputError
from pitotbench.units import KNOT

WIND = Wind(speed=15.0 * KNOT, from_direction=1.0)
VECTOR = CalibrationOptions(form="vector")


@pytest.fixture(scope="module")
def log():
    """One heading, half of the curve's bound is not knowing the wind."""
    case = Case(maneuver="rapid_decel", turbulence="light", wind=WIND, truth_seed=4001, sensor_seed=4001)
    return bench.sense(bench.fly(case), "50/50")


def wind_of(result):
    return np.array([result.wind.north.value, result.wind.east.value])


def bounds_of(result):
    return np.array([result.wind.north.two_sigma, result.wind.east.two_sigma])


def test_it_knows_the_wind_better_and_says_so(log):
    scalar, vector = calibrate(log), calibrate(log, VECTOR)
    assert bounds_of(vector).max() < 0.5 * bounds_of(scalar).max()
    assert vector.curve.two_sigma.mean() < 0.97 * scalar.curve.two_sigma.mean()
    error = wind_of(vector) - bench.wind_toward(WIND)[:2]
    assert np.all(np.abs(error) < 1.5 * bounds_of(vector))


def test_a_constant_error_of_the_heading_is_carried_in_the_bound(log):
    """One degree is half of the prior's 2σ: the wind moves by less than the bound, which is not narrower for it."""
    turned = replace(log, heading=log.heading + np.radians(1.0))
    straight, off = calibrate(log, VECTOR), calibrate(turned, VECTOR)
    assert np.all(np.abs(wind_of(off) - wind_of(straight)) < bounds_of(straight) + bounds_of(off))
    shift = abs(off.curve.correction - straight.curve.correction)
    assert np.all(shift < off.curve.two_sigma)


def test_north_is_only_a_name(log):
    """Turned by a quarter, log and wind, everything turns along."""
    turned = replace(
        log,
        heading=log.heading + 0.5 * np.pi,
        velocity_north=-log.velocity_east,
        velocity_east=log.velocity_north,
    )
    first, second = calibrate(log, VECTOR), calibrate(turned, VECTOR)
    north, east = wind_of(first)
    np.testing.assert_allclose(wind_of(second), [-east, north], atol=2e-3)
    np.testing.assert_allclose(second.curve.two_sigma, first.curve.two_sigma, rtol=2e-2)


def test_it_works_with_every_wind(log):
    for wind in ("linear", "drifting"):
        result = calibrate(log, replace(VECTOR, wind=wind))
        assert np.all(np.isfinite(result.curve.two_sigma))
        assert np.all(bounds_of(result) > 0.0)


def test_without_flow_angles_it_says_what_is_missing(log):
    with pytest.raises(BadInputError, match="sideslip"):
        calibrate(replace(log, sideslip=None), VECTOR)


def test_models_are_not_weighed_in_it(log):
    with pytest.raises(BadInputError, match="scalar form"):
        CalibrationOptions(form="vector", model="auto")
