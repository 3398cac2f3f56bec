"""Measure the coverage of `--model auto` for curves outside all models of the table. One flight has
many truths.
"""

from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from pitotbench import air
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.campaigns.flights import compare_curve, compare_wind, rms, sense, wind_toward
from pitotbench.pressure_error import REFERENCE_PRESSURE
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import Calibration
from pitotbench.records.case import PressureErrorSpec
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.simulation.sortie import fly
from pitotbench.units import KNOT, Array
from pitotlab.experiment import (
    Budget,
    Experiment,
    Row,
    Trial,
    random_case,
    random_parameters,
    run_experiment,
)


def figures(result: Calibration, flight: Flight) -> dict[str, float]:
    """Return the figures of one calibration against the truth of its flight.

    They are the shares of the curve (100 to 160 KIAS) and of the wind's components inside 2σ [%],
    and the mean 2σ and the rms error of the curve and of the wind [kt].
    """
    curve = compare_curve(result.curve, flight.case.pressure_error)
    wind = compare_wind(result.known_wind, wind_toward(flight.case.wind)[:2])
    return {
        "coverage_percent": 100.0 * curve.inside,
        "wind_coverage_percent": 100.0 * wind.inside,
        "two_sigma_kt": curve.mean_two_sigma / KNOT,
        "rms_error_kt": curve.rms_error / KNOT,
        "wind_two_sigma_kt": wind.mean_two_sigma / KNOT,
        "wind_rms_error_kt": wind.rms_error / KNOT,
    }


def figures_of_log(log: FlightLog, options: CalibrationOptions, flight: Flight) -> dict[str, float]:
    """Return the figures of a log calibrated with these options; none where it does not determine
    the answer.
    """
    try:
        return figures(calibrate(log, options), flight)
    except NoAnswerError:
        return {}


def over_seeds(rows: pd.DataFrame, by: Sequence[str], of: Sequence[str] = ("",)) -> pd.DataFrame:
    """Return one line for each group: shares inside [%], mean 2σ and rms error [kt].

    `of` chooses the curve ("") and the wind ("wind ") for the last two. `answers` is the number of
    calibrations that gave an answer.
    """
    groups = rows.groupby(list(by), sort=False)
    table = pd.DataFrame({"answers": groups["coverage_percent"].count()})
    table["curve inside 2σ [%]"] = groups["coverage_percent"].mean()
    table["± [%]"] = groups["coverage_percent"].sem()
    table["wind inside 2σ [%]"] = groups["wind_coverage_percent"].mean()
    for whose in of:
        name = whose.replace(" ", "_")
        table[f"mean {whose}2σ [kt]"] = groups[f"{name}two_sigma_kt"].mean()
        table[f"{whose}rms error [kt]"] = groups[f"{name}rms_error_kt"].apply(rms)
    return table.reset_index()


FIRST_DEVELOPMENT_SEED = 1
MODELS = ("auto", "inverse+")
_AIRSPEED_KT = np.arange(70.0, 205.0, 2.5)  # of the tables of the true curves

Shape = Callable[[Array, np.random.Generator], Array]


def _inverse_plus(speed: Array, rng: np.random.Generator) -> Array:
    k = random_parameters(rng)
    x = air.impact_pressure(speed * KNOT) / REFERENCE_PRESSURE
    return np.asarray(k[0] + k[1] * x + k[2] / x)


def _bump(speed: Array, rng: np.random.Generator) -> Array:
    law = _inverse_plus(speed, rng)
    height = rng.choice([-1.0, 1.0]) * rng.uniform(0.005, 0.015)
    place, width = rng.uniform(110.0, 150.0), rng.uniform(8.0, 15.0)
    return np.asarray(law + height * np.exp(-0.5 * ((speed - place) / width) ** 2))


def _cubic(speed: Array, rng: np.random.Generator) -> Array:
    k = np.array([-0.02, -0.02, 0.0, 0.0]) + np.array(
        [0.03, 0.015, 0.008, 0.006]
    ) * rng.standard_normal(4)
    return np.asarray(np.polynomial.polynomial.polyval((speed - 130.0) / 30.0, k), dtype=np.float64)


def _power(speed: Array, rng: np.random.Generator) -> Array:
    size, exponent = 0.06 * rng.uniform(0.3, 1.7), rng.uniform(3.0, 8.0)
    return np.asarray(-0.05 + 0.03 * rng.standard_normal() + size * (speed / 100.0) ** -exponent)


def _exponential(speed: Array, rng: np.random.Generator) -> Array:
    size, length = 0.05 * rng.uniform(0.3, 1.7), rng.uniform(15.0, 40.0)
    return np.asarray(
        -0.04 + 0.03 * rng.standard_normal() + size * np.exp((100.0 - speed) / length)
    )


TRUTHS: dict[str, Shape] = {
    "inverse+": _inverse_plus,
    "bump": _bump,
    "cubic": _cubic,
    "power": _power,
    "exponential": _exponential,
}


def truth_of(name: str, seed: int) -> PressureErrorSpec:
    """Return a true curve with parameters drawn from a seed, as a table over indicated airspeed."""
    values = TRUTHS[name](_AIRSPEED_KT, np.random.default_rng([seed, list(TRUTHS).index(name)]))
    return PressureErrorSpec(
        model="table",
        airspeed=tuple(float(v) for v in _AIRSPEED_KT * KNOT),
        values=tuple(float(v) for v in values),
    )


def score_outside(trial: Trial, truths: tuple[str, ...], das: str) -> list[Row]:
    """Fly once, sense with every true curve, calibrate with `auto` and with Inverse+; return one
    row for each.
    """
    flight = fly(random_case(trial))
    rows: list[Row] = []
    for name in truths:
        case = replace(flight.case, pressure_error=truth_of(name, trial.seed))
        rows += _rows(trial, name, replace(flight, case=case), das)
    return rows


def _rows(trial: Trial, name: str, flight: Flight, das: str) -> Iterator[Row]:
    log = sense(flight, das)
    for model in MODELS:
        row = trial.cell | {"truth": name, "model": model}
        yield row | figures_of_log(log, CalibrationOptions(model=model), flight)


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Measure `--model auto` on curves outside the table of models, beside a fit with Inverse+.

    Prints a page (Markdown) with one line a maneuver, truth and model. About 4 CPU seconds a seed
    and maneuver at 50/50 Hz. The seeds from 200001 on are never used in development.
    """
    parser.add_argument(
        "--maneuver", default="step_decrease,circle", help="comma list (default: %(default)s)"
    )
    parser.add_argument("--das", default="50/50", help="data system (default: %(default)s)")
    parser.add_argument(
        "--turbulence", default="light", help="none, light or moderate (default: %(default)s)"
    )
    parser.add_argument(
        "--seeds", type=int, default=10, help="flights of each maneuver (default: %(default)s)"
    )
    parser.add_argument(
        "--first", type=int, default=FIRST_DEVELOPMENT_SEED, help="first seed (default: 1)"
    )
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    options = parser.parse_args(words)
    from pitotlab.pages import auto_page  # loads the drawing library

    seeds = range(options.first, options.first + options.seeds)
    score, maneuvers = partial(score_outside, das=options.das), tuple(options.maneuver.split(","))
    experiment = Experiment(score, maneuvers, (options.turbulence,), tuple(TRUTHS), "truth")
    rows = run_experiment(experiment, seeds, Budget(options.jobs))
    asked = {name: getattr(options, name) for name in ("maneuver", "turbulence", "das")}
    print(
        auto_page(over_seeds(rows, ("maneuver", "truth", "model")), list(TRUTHS), seeds, asked),
        end="",
    )
