"""Measure the coverage of `--model auto` for curves outside all models of the table. One flight has many truths."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from pitotbench import air, bench
from pitotbench.evidence.bounds.figures import figures_of_log, over_seeds
from pitotbench.evidence.experiment import Experiment, Row, Trial
from pitotbench.evidence.random_truth import random_case, random_parameters
from pitotbench.pressure_error import REFERENCE_PRESSURE
from pitotbench.records.case import PressureErrorSpec
from pitotbench.records.flight import Flight
from pitotbench.units import KNOT, Array

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
    k = np.array([-0.02, -0.02, 0.0, 0.0]) + np.array([0.03, 0.015, 0.008, 0.006]) * rng.standard_normal(4)
    return np.asarray(np.polynomial.polynomial.polyval((speed - 130.0) / 30.0, k), dtype=np.float64)


def _power(speed: Array, rng: np.random.Generator) -> Array:
    size, exponent = 0.06 * rng.uniform(0.3, 1.7), rng.uniform(3.0, 8.0)
    return np.asarray(-0.05 + 0.03 * rng.standard_normal() + size * (speed / 100.0) ** -exponent)


def _exponential(speed: Array, rng: np.random.Generator) -> Array:
    size, length = 0.05 * rng.uniform(0.3, 1.7), rng.uniform(15.0, 40.0)
    return np.asarray(-0.04 + 0.03 * rng.standard_normal() + size * np.exp((100.0 - speed) / length))


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


def outside_experiment(maneuvers: Sequence[str], turbulence: str, das: str) -> Experiment:
    """Return the experiment: these maneuvers in one turbulence, every flight sensed with every true curve."""
    return Experiment(partial(score_outside, das=das), tuple(maneuvers), (turbulence,), tuple(TRUTHS), "truth")


def score_outside(trial: Trial, truths: tuple[str, ...], das: str) -> list[Row]:
    """Fly once, sense with every true curve, calibrate with `auto` and with Inverse+; return one row for each."""
    flight = bench.fly(random_case(trial))
    rows: list[Row] = []
    for name in truths:
        case = replace(flight.case, pressure_error=truth_of(name, trial.seed))
        rows += _rows(trial, name, replace(flight, case=case), das)
    return rows


def _rows(trial: Trial, name: str, flight: Flight, das: str) -> Iterator[Row]:
    log = bench.sense(flight, das)
    cell: Row = {"maneuver": trial.maneuver, "turbulence": trial.turbulence, "truth": name}
    for model in MODELS:
        base = cell | {"model": model, "seed": trial.seed}
        yield base | figures_of_log(log, bench.CalibrationOptions(model=model), flight)


def summarize(rows: pd.DataFrame) -> pd.DataFrame:
    """Return one line for each maneuver, truth and model: shares inside [%], mean 2σ and rms error [kt] over seeds.

    `answers` is the number of calibrations that gave an answer.
    """
    return over_seeds(rows, ("maneuver", "truth", "model"))
