"""A forecast of the planner against flights and calibrations.

With an error of the static source the altitude equation narrows the bound. The receiver then stands
alone: its height has a white error of 0.3 m and a slow one of 2 m over 90 s.
"""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import CalibrationOptions, Case, PlanRequest
from pitotbench.bench.forecasts import forecast, known_noise_two_sigma, smooth_flight
from pitotbench.calibration import calibrate
from pitotbench.campaigns.flights import score, sense
from pitotbench.records.case import PressureErrorSpec
from pitotbench.sensing.sampling import data_system, has_velocity_down
from pitotbench.simulation.sortie import fly
from pitotbench.units import FOOT

TRIANGLE, HEIGHT, VELOCITY = "triangle", "height", "height and velocity"
ALTITUDE = 3350.0 * FOOT  # m: light turbulence is 0.5 m/s there (MIL-F-8785C, Fig. 7)
_TURBULENCE = "light"
_RECEIVER = replace(
    data_system("20/1"), velocity_noise=0.05, altitude_noise=0.3, altitude_drift=2.0
)


def request_with(receiver: str) -> PlanRequest:
    """Return the request for a plan with the triangle alone, the height, or the velocity too."""
    error = PressureErrorSpec(location="static")
    case = Case(turbulence=_TURBULENCE, altitude=ALTITUDE, pressure_error=error)
    options = CalibrationOptions()
    if receiver == TRIANGLE:
        options = replace(options, error_location="static", use_altitude=False)
    down = "recorded" if receiver == VELOCITY else "missing"
    return PlanRequest(case, system=replace(_RECEIVER, vertical_velocity=down), options=options)


def test_a_forecast_foretells_the_bound_of_flights():
    """Three flights in the simulator's turbulence against the forecast."""
    request = PlanRequest(Case(), draws=10, maneuvers=("decel_circle",))
    expected = forecast(request, "decel_circle").mean
    case = Case(maneuver="decel_circle")
    flights = [fly(replace(case, truth_seed=seed, sensor_seed=seed)) for seed in (1, 2, 3)]
    flown = [score(calibrate(sense(f, "20/1"), request.options), f).two_sigma for f in flights]
    assert expected == pytest.approx(np.mean(flown), rel=0.2)


@pytest.mark.parametrize(("velocity", "expected"), [("recorded", 0.49), ("missing", 0.64)])
def test_height_narrows_the_bound_of_a_static_error_in_the_forecast_too(velocity, expected):
    """`expected`: of 12 flights a receiver, calibrated in the simulator's turbulence."""
    joint = request_with(VELOCITY if velocity == "recorded" else HEIGHT)
    assert has_velocity_down(joint.das) == (velocity == "recorded")
    flight = smooth_flight(joint, "step_decrease")
    asked = (joint, request_with(TRIANGLE))
    known = [np.mean(known_noise_two_sigma(each, flight)) for each in asked]
    drawn = [forecast(replace(each, draws=4), "step_decrease").mean for each in asked]
    assert known[0] / known[1] == pytest.approx(expected, rel=0.15)
    assert drawn[0] / drawn[1] == pytest.approx(expected, rel=0.15)


def test_an_error_of_the_impact_pressure_is_not_seen_by_the_height():
    static = request_with(VELOCITY)
    flight = smooth_flight(static, "step_decrease")
    impact = replace(static, options=CalibrationOptions(error_location="impact"))
    wide, narrow = (np.mean(known_noise_two_sigma(each, flight)) for each in (impact, static))
    assert wide > 1.5 * narrow
