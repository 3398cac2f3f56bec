"""End to end, and the comparison with the truth: what is inside, and that NaN hides nowhere."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from pitotbench import Case, UnknownNameError
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
    # The score is the comparison.
    compared, found = score(result, flight), compare_curve(curve, truth)
    assert (compared.curve_rms_error, compared.curve_coverage) == (found.rms_error, found.inside)
    assert compared.two_sigma == found.mean_two_sigma


def test_a_wind_is_compared_by_component():
    wind = WindEstimate(Estimate("north", 3.0, 0.5), Estimate("east", -4.0, 2.0))
    found = compare_wind(wind, np.array([2.0, -3.0]))
    np.testing.assert_allclose(found.error, [1.0, -1.0])
    assert found.inside == 0.5


def test_points_of_a_log_are_near_the_truth_at_their_airspeeds(smooth_flights):
    flight = smooth_flights["four_leg"]
    points = fixed_speed_points(sense(flight, "50/50"))
    airspeeds = np.array([point.indicated_airspeed for point in points])
    truth = true_correction(flight.case.pressure_error, airspeeds)
    assert len(points) > 0
    assert [point.correction for point in points] == pytest.approx(truth, abs=0.2 * KNOT)


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


def test_light_turbulence_stays_inside_three_sigma(light_flights):
    flight = light_flights["circle"]
    result = calibrate(sense(flight, "20/1"))
    truth = true_correction(flight.case.pressure_error, result.curve.indicated_airspeed)
    assert np.all(np.abs(result.curve.correction - truth) <= 1.5 * result.curve.two_sigma)


def test_wind_blows_from_where_it_is_said_and_an_unknown_effect_is_refused():
    north, east, down = wind_toward(Wind(speed=10.0, from_direction=90.0 * DEGREE, up=1.0))
    assert (north, east, down) == pytest.approx((0.0, -10.0, -1.0), abs=1e-12)
    with pytest.raises(UnknownNameError, match=r"effect.*belly_pod"):
        fly(Case(effects=(EffectSpec("jelly_pod"),)))
