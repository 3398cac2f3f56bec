"""End to end: fly a known error, find it; the score; the log that is written carries no truth."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import Case, UnknownNameError, bench
from pitotbench.records.case import EffectSpec, PressureErrorSpec, Wind
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.units import DEGREE, KNOT


@pytest.mark.parametrize("maneuver", list(MANEUVERS))
def test_the_injected_curve_comes_back_in_calm_air(maneuver, smooth_flights):
    flight = smooth_flights[maneuver]
    result = bench.calibrate(bench.sense(flight, "50/50"))
    score = bench.score(result, flight)
    assert score.curve_rms_error <= 0.05 * KNOT
    assert score.wind_error <= 0.05 * KNOT
    # The score compares with the flight's own truth: another truth gives another score.
    shifted = replace(flight.case, pressure_error=PressureErrorSpec(parameters=(-0.04, 0.006, 0.06)))
    assert bench.score(result, replace(flight, case=shifted)).curve_rms_error > 10.0 * score.curve_rms_error


@pytest.mark.parametrize("maneuver", ["four_leg", "circle"])
def test_light_turbulence_stays_inside_three_sigma(maneuver, light_flights):
    flight = light_flights[maneuver]
    result = bench.calibrate(bench.sense(flight, "20/1"))
    truth = bench.true_correction(flight.case.pressure_error, result.curve.indicated_airspeed)
    assert np.all(np.abs(result.curve.correction - truth) <= 1.5 * result.curve.two_sigma)


def test_wind_blows_from_where_it_is_said_and_an_unknown_effect_is_refused():
    north, east, down = bench.wind_toward(Wind(speed=10.0, from_direction=90.0 * DEGREE, up=1.0))
    assert (north, east, down) == pytest.approx((0.0, -10.0, -1.0), abs=1e-12)
    with pytest.raises(UnknownNameError, match=r"effect.*belly_pod"):
        bench.fly(Case(effects=(EffectSpec("jelly_pod"),)))
