"""How often fixed-speed points from simulated logs hold the truth, for several ways of flying and labeling."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from pitotbench.bench import calibrate, fixed_speed_points, fly, sense, true_correction, wind_toward
from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.case import Case, Wind
from pitotbench.records.fixed_speed_point import FixedSpeedPoint
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT, Array


@dataclass(frozen=True, slots=True)
class Way:
    """A maneuver, and what is left of its log before the points are looked for."""

    maneuver: str
    seen: Callable[[FlightLog], FlightLog]


@dataclass(frozen=True, slots=True)
class Reduced:
    """A simulated log with the curve found in it."""

    case: Case
    log: FlightLog
    curve: ErrorCurve


def _unlabeled(log: FlightLog) -> FlightLog:
    return replace(log, segment=None, on_condition=None)


def _without_the_last_leg(log: FlightLog) -> FlightLog:
    assert log.segment is not None  # the simulator labels its logs
    return log.select(np.char.find(log.segment, "270°") < 0)


WAYS = {
    "four legs, labeled": Way("four_leg", lambda log: log),
    "four legs, found": Way("four_leg", _unlabeled),
    "three legs, labeled": Way("four_leg", _without_the_last_leg),
    "turn, labeled": Way("circle", lambda log: log),
    "turn, found": Way("circle", _unlabeled),
}


def score_fixed_speed(turbulence: str, das: str, seeds: Sequence[int]) -> Iterator[str]:
    """A line of figures for each way and method: share of points inside 2σ, mean and rms error, mean 2σ, share of
    winds (both components) inside 2σ, share of points inside twice the spread, and the rms difference to the curve
    of the whole log with the share of it inside the point's 2σ."""
    flown = {
        maneuver: [_reduced(_case(maneuver, turbulence, seed), das) for seed in seeds]
        for maneuver in dict.fromkeys(way.maneuver for way in WAYS.values())
    }
    for name, way in WAYS.items():
        found = [(log, point) for log in flown[way.maneuver] for point in fixed_speed_points(way.seen(log.log))]
        for method in dict.fromkeys(point.method for _, point in found):
            rows = np.array([_errors(log, point) for log, point in found if point.method == method])
            yield f"{turbulence:5s} | {name:19s} | {method:9s} | {_figures(rows)}"


def _case(maneuver: str, turbulence: str, seed: int) -> Case:
    """A case with a wind of its own, up to 25 kt from anywhere."""
    rng = np.random.default_rng(7000 + seed)
    wind = Wind(speed=rng.uniform(0.0, 25.0) * KNOT, from_direction=rng.uniform(0.0, 2.0 * np.pi))
    return Case(maneuver=maneuver, turbulence=turbulence, truth_seed=seed, sensor_seed=seed, wind=wind)


def _reduced(case: Case, das: str) -> Reduced:
    log = sense(fly(case), das)
    return Reduced(case, log, calibrate(log).curve)


def _errors(flown: Reduced, point: FixedSpeedPoint) -> Array:
    """Error, 2σ and spread of the airspeed, larger error and 2σ of the wind, correction less the curve's [kt]."""
    case, curve = flown.case, flown.curve
    error = point.correction - true_correction(case.pressure_error, np.array([point.indicated_airspeed]))[0]
    wind = np.abs(np.array([point.wind_north, point.wind_east]) - wind_toward(case.wind)[:2]).max()
    spread = np.nan if point.spread is None else point.spread
    off = point.correction - float(
        CubicSpline(curve.indicated_airspeed, curve.correction)(point.indicated_airspeed)
    )
    return np.array([error, point.two_sigma, spread, wind, point.wind_two_sigma, off]) / KNOT


def _figures(rows: Array) -> str:
    error, bound, spread, wind, wind_bound, off = rows.T
    doubled = "-" if np.isnan(spread).all() else f"{np.mean(np.abs(error) <= 2.0 * spread):.0%}"
    return (
        f"{len(error):3d} points | inside {np.mean(np.abs(error) <= bound):4.0%} | "
        f"mean {error.mean():+.3f} rms {np.sqrt(np.mean(error**2)):.3f} 2σ {bound.mean():.3f} kt | "
        f"wind inside {np.mean(wind <= wind_bound):4.0%} | inside two spreads {doubled} | "
        f"less curve rms {np.sqrt(np.mean(off**2)):.3f} kt, inside {np.mean(np.abs(off) <= bound):4.0%}"
    )
