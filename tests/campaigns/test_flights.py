"""End to end, and the comparison with the truth: what is inside, and that NaN hides nowhere."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from pitotbench import Case, UnknownNameError, air
from pitotbench.calibration import calibrate
from pitotbench.calibration.leg_points import fixed_speed_points
from pitotbench.campaigns.flights import (
    Comparison,
    compare_curve,
    compare_wind,
    rms,
    score,
    scored,
    sense,
    true_correction,
    wind_toward,
)
from pitotbench.records.calibration import Estimate, WindEstimate
from pitotbench.records.case import EffectSpec, PressureErrorSpec, Wind
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.simulation.sortie import fly
from pitotbench.units import DEGREE, KNOT
from pitotlab.fixed_speed import compare_points
from pitotlab.plan_check import compare_altitude, compare_curve_at, true_altitude_correction


@pytest.fixture(scope="module")
def calibrated(smooth_flights):
    flight = smooth_flights["rapid_decel"]
    return flight, calibrate(sense(flight, "20/1"))


def test_figures_are_those_of_the_errors_and_an_error_that_is_no_number_is_not_inside():
    found = Comparison(np.array([1.0, -2.0, 2.0, -1.0]), np.array([1.0, 1.0, 3.0, 3.0]))
    assert found.inside == 0.75
    assert found.rms_error == pytest.approx(np.sqrt(2.5))
    assert found.mean_two_sigma == 2.0
    assert Comparison(found.error, found.two_sigma + 1.0).inside == 1.0
    found = Comparison(np.array([0.0, np.nan]), np.array([1.0, 1.0]))
    assert found.inside == 0.5
    assert np.isnan(found.rms_error)
    # A missing number of a table is skipped.
    assert rms(pd.Series([3.0, np.nan, 4.0])) == pytest.approx(np.sqrt(12.5))
    assert np.isnan(rms(np.array([3.0, np.nan])))


def test_a_curve_shifted_by_a_knot_is_a_knot_wrong(calibrated):
    flight, result = calibrated
    truth, curve = flight.case.pressure_error, result.curve
    exact = replace(curve, correction=true_correction(truth, curve.indicated_airspeed) + KNOT)
    found = compare_curve(exact, truth)
    assert len(found.error) == scored(exact).sum() < len(exact.correction)
    assert np.mean(found.error) == pytest.approx(KNOT)
    between = compare_curve_at(exact, truth, np.array([101.0, 133.3]) * KNOT)
    np.testing.assert_allclose(between.error, KNOT, rtol=1e-2)
    # The score is the comparison.
    compared, found = score(result, flight), compare_curve(curve, truth)
    assert (compared.curve_rms_error, compared.curve_coverage) == (found.rms_error, found.inside)
    assert compared.two_sigma == found.mean_two_sigma


def test_a_wind_is_compared_by_component():
    wind = WindEstimate(Estimate("north", 3.0, 0.5), Estimate("east", -4.0, 2.0))
    found = compare_wind(wind, np.array([2.0, -3.0]))
    np.testing.assert_allclose(found.error, [1.0, -1.0])
    assert found.inside == 0.5


def test_points_are_compared_at_their_airspeeds(smooth_flights):
    flight = smooth_flights["four_leg"]
    points = fixed_speed_points(sense(flight, "50/50"))
    found = compare_points(points, flight.case.pressure_error)
    assert found.error.shape == (len(points),)
    assert np.abs(found.error).max() < 0.2 * KNOT
    moved = [replace(point, correction=point.correction + KNOT) for point in points]
    np.testing.assert_allclose(
        compare_points(moved, flight.case.pressure_error).error - found.error, KNOT, atol=1e-9
    )


def test_the_altitude_correction_is_held_against_the_true_static_pressure(calibrated):
    """The recorded static pressure of a flight whose sensors are exact, against its true one, at
    one airspeed.
    """
    spec = replace(calibrated[0].case.pressure_error, location="static")
    airspeed, indicated = np.array([120.0 * KNOT]), 80000.0
    impact = air.impact_pressure(airspeed + true_correction(spec, airspeed))
    true = indicated - (impact - air.impact_pressure(airspeed))
    higher = air.pressure_altitude(true) - air.pressure_altitude(indicated)
    curve = calibrated[1].curve
    ones = np.ones_like(curve.correction)
    right = true_altitude_correction(spec, curve.indicated_airspeed, indicated)
    assert true_altitude_correction(spec, airspeed, indicated) == pytest.approx(higher, abs=1e-9)
    assert compare_altitude(curve, spec, indicated) is None
    for off in (0.0, -3.0):
        given = replace(curve, altitude_correction=right + off, altitude_two_sigma=ones)
        assert np.mean(compare_altitude(given, spec, indicated).error) == pytest.approx(off)
    assert not np.any(
        true_altitude_correction(replace(spec, location="total"), airspeed, indicated)
    )


@pytest.mark.parametrize("maneuver", list(MANEUVERS))
def test_the_injected_curve_comes_back_in_calm_air(maneuver, smooth_flights):
    flight = smooth_flights[maneuver]
    result = calibrate(sense(flight, "50/50"))
    compared = score(result, flight)
    assert compared.curve_rms_error <= 0.05 * KNOT
    assert compared.wind_error <= 0.05 * KNOT
    # The score compares with the flight's own truth: another truth gives another score.
    shifted = replace(
        flight.case, pressure_error=PressureErrorSpec(parameters=(-0.04, 0.006, 0.06))
    )
    assert (
        score(result, replace(flight, case=shifted)).curve_rms_error
        > 10.0 * compared.curve_rms_error
    )


@pytest.mark.parametrize("maneuver", ["four_leg", "circle"])
def test_light_turbulence_stays_inside_three_sigma(maneuver, light_flights):
    flight = light_flights[maneuver]
    result = calibrate(sense(flight, "20/1"))
    truth = true_correction(flight.case.pressure_error, result.curve.indicated_airspeed)
    assert np.all(np.abs(result.curve.correction - truth) <= 1.5 * result.curve.two_sigma)


def test_wind_blows_from_where_it_is_said_and_an_unknown_effect_is_refused():
    north, east, down = wind_toward(Wind(speed=10.0, from_direction=90.0 * DEGREE, up=1.0))
    assert (north, east, down) == pytest.approx((0.0, -10.0, -1.0), abs=1e-12)
    with pytest.raises(UnknownNameError, match=r"effect.*belly_pod"):
        fly(Case(effects=(EffectSpec("jelly_pod"),)))
