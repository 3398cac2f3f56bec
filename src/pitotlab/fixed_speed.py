"""Measure how often the bounds of fixed-speed points from simulated logs contain the truth, for
several ways.
"""

from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline

from pitotbench.calibration import calibrate
from pitotbench.calibration.leg_points import fixed_speed_points
from pitotbench.campaigns.flights import Comparison, sense, true_correction, wind_toward
from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.case import Case, PressureErrorSpec, Wind
from pitotbench.records.legs import FixedSpeedPoint
from pitotbench.records.log import FlightLog
from pitotbench.simulation.sortie import fly
from pitotbench.units import KNOT
from pitotlab.experiment import NO_LIMIT, Budget, Experiment, Row, Trial, run_experiment


@dataclass(frozen=True, slots=True)
class Way:
    """A maneuver, and the part of its log in which points are searched."""

    maneuver: str
    part: Callable[[FlightLog], FlightLog]


def _whole(log: FlightLog) -> FlightLog:
    return log


def _unlabeled(log: FlightLog) -> FlightLog:
    return replace(log, segment=None, on_condition=None)


def _without_the_last_leg(log: FlightLog) -> FlightLog:
    assert log.segment is not None  # every simulated log has labels
    return log.select(np.char.find(log.segment, "270°") < 0)


WAYS = {
    "four legs, labeled": Way("four_leg", _whole),
    "four legs, found": Way("four_leg", _unlabeled),
    "three legs, labeled": Way("four_leg", _without_the_last_leg),
    "turn, labeled": Way("circle", _whole),
    "turn, found": Way("circle", _unlabeled),
}


def score_fixed_speed(
    turbulence: str, das: str, seeds: Sequence[int], budget: Budget = NO_LIMIT
) -> Iterator[str]:
    """Return a line of figures for each way and method.

    They are the share of points inside 2σ, the mean and the rms error, the mean 2σ, the share of
    winds (both components) inside 2σ, the share of points inside twice the spread, the rms
    difference from the curve of the whole log, and the share of these differences inside the
    point's 2σ.
    """
    maneuvers = tuple(dict.fromkeys(way.maneuver for way in WAYS.values()))
    experiment = Experiment(
        partial(points_of, das=das), maneuvers, (turbulence,), tuple(WAYS), "way"
    )
    rows = run_experiment(experiment, seeds, budget)
    for name in WAYS:
        for method, group in rows[rows["way"] == name].groupby("method", sort=False):
            yield f"{turbulence:5s} | {name:19s} | {method:9s} | {_figures(group)}"


def points_of(trial: Trial, ways: tuple[str, ...], das: str) -> list[Row]:
    """Fly once and calibrate the whole log; return a row for each fixed-speed point of each way of
    the maneuver.
    """
    case = _case(trial)
    log = sense(fly(case), das)
    curve = calibrate(log).curve
    rows: list[Row] = []
    for name in (name for name in ways if WAYS[name].maneuver == trial.maneuver):
        cell = trial.cell | {"way": name}
        rows += [
            cell | _errors(case, curve, point) for point in fixed_speed_points(WAYS[name].part(log))
        ]
    return rows


def _case(trial: Trial) -> Case:
    """Return a case with the default pressure error and a random wind of its seed, up to 25 kt."""
    rng = np.random.default_rng(7000 + trial.seed)
    wind = Wind(speed=rng.uniform(0.0, 25.0) * KNOT, from_direction=rng.uniform(0.0, 2.0 * np.pi))
    flown = Case(maneuver=trial.maneuver, turbulence=trial.turbulence, wind=wind)
    return replace(flown, truth_seed=trial.seed, sensor_seed=trial.seed)


def compare_points(points: Sequence[FixedSpeedPoint], truth: PressureErrorSpec) -> Comparison:
    """Compare fixed-speed points with the truth at their airspeeds."""
    airspeed, correction, two_sigma = np.array(
        [(point.indicated_airspeed, point.correction, point.two_sigma) for point in points]
    ).T
    return Comparison(correction - true_correction(truth, airspeed), two_sigma)


def _errors(case: Case, curve: ErrorCurve, point: FixedSpeedPoint) -> Row:
    """Return the errors of a point [kt] as columns of its row.

    They are the error, 2σ and spread of the airspeed, the larger error and 2σ of the wind, and the
    correction minus that of the curve.
    """
    found = compare_points([point], case.pressure_error)
    wind = np.abs(np.array([point.wind_north, point.wind_east]) - wind_toward(case.wind)[:2]).max()
    at_speed = float(
        CubicSpline(curve.indicated_airspeed, curve.correction)(point.indicated_airspeed)
    )
    return {
        "method": point.method,
        "error_kt": float(np.mean(found.error)) / KNOT,
        "two_sigma_kt": point.two_sigma / KNOT,
        "spread_kt": np.nan if point.spread is None else point.spread / KNOT,
        "wind_error_kt": wind / KNOT,
        "wind_two_sigma_kt": point.wind_two_sigma / KNOT,
        "less_curve_kt": (point.correction - at_speed) / KNOT,
    }


def _figures(rows: pd.DataFrame) -> str:
    """Return the figures of the points of one way and method."""
    column = {name: rows[name].to_numpy() for name in rows if str(name).endswith("_kt")}
    two_sigma, spread = column["two_sigma_kt"], column["spread_kt"]
    points = Comparison(column["error_kt"], two_sigma)
    doubled = (
        "-" if np.isnan(spread).all() else f"{replace(points, two_sigma=2.0 * spread).inside:.0%}"
    )
    wind = Comparison(column["wind_error_kt"], column["wind_two_sigma_kt"])
    off = Comparison(column["less_curve_kt"], two_sigma)
    return (
        f"{len(rows):3d} points | inside {points.inside:4.0%} | "
        f"mean {np.mean(points.error):+.3f} rms {points.rms_error:.3f} 2σ "
        f"{points.mean_two_sigma:.3f} kt | "
        f"wind inside {wind.inside:4.0%} | inside two spreads {doubled} | "
        f"less curve rms {off.rms_error:.3f} kt, inside {off.inside:4.0%}"
    )


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Print how often fixed-speed points from simulated logs hold the truth.

    Seeds 1 to N are development seeds; winds are drawn up to 25 kt.
    """
    parser.add_argument(
        "--seeds", type=int, default=10, help="flights a cell (default: %(default)s)"
    )
    parser.add_argument("--das", default="50/50", help="data system (default: %(default)s)")
    parser.add_argument(
        "--turbulence", default="none,light", help="comma list (default: %(default)s)"
    )
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    options = parser.parse_args(words)
    for turbulence in options.turbulence.split(","):
        seeds = range(1, options.seeds + 1)
        for line in score_fixed_speed(turbulence, options.das, seeds, Budget(options.jobs)):
            print(line, flush=True)
