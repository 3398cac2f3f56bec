"""Predict the bound of a card before it is flown, from a simulated flight in smooth air with random gusts added."""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from pitotbench import bench
from pitotbench.bench.plan.drawn_gusts import MEAN_LENGTH, gust_deviation, stirred
from pitotbench.bench.plan.plan_request import PlanRequest
from pitotbench.calibrate.expected_bound import ExpectedNoise, expected_two_sigma
from pitotbench.calibrate.options import AUTO
from pitotbench.records.case import DataSystem
from pitotbench.records.case_file import read_case, write_case
from pitotbench.records.flight import Flight
from pitotbench.records.forecast import Forecast
from pitotbench.records.integration import rates_for
from pitotbench.sense import CALIBRATION_CHANNELS
from pitotbench.simulate.attach.record import read_record
from pitotbench.simulate.hangar import find_aircraft
from pitotbench.timeline import gaps
from pitotbench.units import Array, MetersPerSecond

_CHANNELS = (
    *CALIBRATION_CHANNELS, "true_airspeed", "wind_north", "wind_east", "wind_down", "roll", "position_north",
    "position_east",
)  # fmt: skip
_KEPT_FLIGHTS = 16
_FIRST_DRAW = 1


def forecast(request: PlanRequest, maneuver: str, card: Mapping[str, Any] | None = None) -> Forecast:
    """Predict the bound of a maneuver, with the numbers of its card that are in `card` changed.

    Raises SimulationError where the card cannot be flown, NoAnswerError where it does not determine the answer.
    """
    flight = smooth_flight(request, maneuver, card)
    bounds = np.stack([_drawn(request, flight, seed) for seed in range(_FIRST_DRAW, _FIRST_DRAW + request.draws)])
    return Forecast(
        maneuver=maneuver,
        card=dict(card or {}),
        minutes=flight.duration / 60.0,
        elapsed_minutes=float(np.ptp(flight["time"])) / 60.0,
        steepest_bank=float(np.abs(flight["roll"]).max()),
        extent=(float(np.ptp(flight["position_north"])), float(np.ptp(flight["position_east"]))),
        airspeeds=request.airspeeds,
        two_sigma=bounds.mean(axis=0),
        known_noise_two_sigma=known_noise_two_sigma(request, flight),
        spread=float(bounds.mean(axis=1).std(ddof=1)),
        track=_track(flight),
    )


def _track(flight: Flight) -> Array:
    """Return the ground track, north and east [m], (2, k), one point a second; NaN where nothing was recorded."""
    time = flight["time"]
    rows = np.flatnonzero(np.diff(np.floor(time - time[0]), prepend=-1.0) > 0.0)
    track = np.stack([flight["position_north"][rows], flight["position_east"][rows]])
    return np.insert(track, gaps(time[rows]), np.nan, axis=1)


def smooth_flight(request: PlanRequest, maneuver: str, card: Mapping[str, Any] | None = None) -> Flight:
    """Return the flight of a maneuver in smooth air. The last few are kept in memory.

    It is integrated at the slowest rate that fits the data system, where the airplane is one of the bench:
    docs/speed.md measures what that changes. A fast airplane of JSBSim's library may need the usual rate.
    """
    case = replace(request.case(maneuver, dict(card or {})), das=request.das)
    attached = read_record(find_aircraft(case.aircraft)) is not None
    rate = case.integration_rate if attached else rates_for(request.das.air_rate)[0]
    return _flown(write_case(replace(case, integration_rate=rate)))


@lru_cache(_KEPT_FLIGHTS)
def _flown(case: str) -> Flight:
    return bench.fly(read_case(case), channels=_CHANNELS)


def known_noise_two_sigma(request: PlanRequest, flight: Flight) -> MetersPerSecond:
    """Return 2σ [m/s] at the request's airspeeds by the information matrix, for gusts of the expected level."""
    level = gust_deviation(request.base)
    theta = np.concatenate(
        [np.array(request.base.pressure_error.parameters), bench.wind_toward(request.base.wind)[:2]]
    )
    noise = ExpectedNoise(gust_deviation=level, gust_length=MEAN_LENGTH, **_height_noise(request.das))
    location = request.options.error_location
    if location == AUTO:  # the calibrator finds the place from the height, or assumes the published one
        location = request.base.pressure_error.location
    log = bench.sense(flight, request.das)
    options = replace(request.options, error_location=location)
    return expected_two_sigma(log, options, theta, noise, request.airspeeds)


def _height_noise(das: DataSystem) -> dict[str, float]:
    """Return the noise of the receiver's height and vertical velocity, as `ExpectedNoise` names it."""
    return {
        "height_deviation": das.altitude_drift,
        "height_memory": das.altitude_drift_time,
        "height_white": das.altitude_noise,
        "height_walk": das.velocity_noise / das.gps_rate**0.5,
    }


def _drawn(request: PlanRequest, flight: Flight, seed: int) -> MetersPerSecond:
    """Return the calibrator's 2σ [m/s] at the request's airspeeds, for one draw of gusts and sensor noise."""
    log = bench.sense(stirred(flight, request.base.turbulence, seed), request.das)
    curve = bench.calibrate(log, request.options).curve
    return np.interp(request.airspeeds, curve.indicated_airspeed, curve.two_sigma)
