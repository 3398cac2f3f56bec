"""The smooth curve and the fixed-speed methods treat the location of the error as a law does."""

from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import static_flights as fixture

from pitotbench import CalibrationOptions
from pitotbench.calibration import calibrate
from pitotbench.calibration.leg_points import cross_check, fixed_speed_points
from pitotbench.campaigns.flights import sense


def _stated(location, **changes):
    return CalibrationOptions(error_location=location, **changes)


@pytest.fixture(scope="module")
def bare():
    return fixture.without_height(fixture.fly("circle", 5))


@pytest.fixture(scope="module")
def total(bare):
    return calibrate(bare, _stated("total", model="smooth")).curve


@pytest.fixture(scope="module")
def turns(light_flights):
    """A flight of turns with the error at the static source, as a log that is not marked as
    synthetic.
    """
    flight = light_flights["circle"]
    spec = replace(flight.case.pressure_error, location="static")
    log = sense(replace(flight, case=replace(flight.case, pressure_error=spec)), "20/1")
    return replace(log, header={"accuracy": fixture.EXACT, "priors": fixture.COLUMNS})


def test_a_smooth_curve_without_height_allows_for_the_other_location(bare, total):
    free, static = (
        calibrate(bare, _stated(name, model="smooth")).curve for name in ("auto", "static")
    )
    apart = total.correction - static.correction
    np.testing.assert_allclose(free.correction, static.correction, atol=1e-4)
    np.testing.assert_allclose(free.two_sigma, np.hypot(static.two_sigma, 2.0 * apart), rtol=0.05)
    assert np.max(free.two_sigma / static.two_sigma) > 1.005


def test_fixed_speed_points_and_the_cross_check_find_the_location_by_the_height(turns):
    here, there, known = (
        fixed_speed_points(turns, _stated(name)) for name in ("static", "total", "auto")
    )
    assert len(here) >= 3
    for point, static, total in zip(known, here, there, strict=True):
        # A share of some percent may remain for the other location.
        assert abs(point.correction - static.correction) <= 0.1 * abs(
            total.correction - static.correction
        )
        assert (
            static.two_sigma
            <= point.two_sigma
            < static.two_sigma + abs(total.correction - static.correction)
        )
    found = calibrate(turns)
    assert found.error_location == "static"
    checked = [p.correction for p in cross_check(turns, None, found)]
    assert checked == pytest.approx([p.correction for p in known], abs=1e-6)


def test_fixed_speed_points_without_height_are_static_with_the_difference_in_the_bound(turns):
    log = replace(turns, altitude=None)
    here, there = (fixed_speed_points(log, _stated(name)) for name in ("static", "total"))
    for point, static, total in zip(fixed_speed_points(log), here, there, strict=True):
        assert point.correction == pytest.approx(static.correction, abs=1e-9)
        apart = total.correction - static.correction
        assert point.two_sigma == pytest.approx(np.hypot(static.two_sigma, 2.0 * apart), rel=1e-6)
        assert abs(apart) > 1e-3
