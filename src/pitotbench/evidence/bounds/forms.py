"""Compare the scalar and the vector form on the same flights: the gain from imperfect attitude and flow angles."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from pitotbench import bench
from pitotbench.calibrate.options import FORMS
from pitotbench.evidence.bounds.figures import figures_of_log, over_seeds
from pitotbench.evidence.experiment import Experiment, Row, Trial
from pitotbench.evidence.random_truth import random_case
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.simulate import PAPER_MANEUVERS

FIRST_SCORED_SEED = 300_001
_HEADING, _VANES = np.radians(1.0), np.radians(0.5)  # standard deviations of constant errors


def forms_experiment(turbulence: str, das: str) -> Experiment:
    """Return the experiment: all published maneuvers in one turbulence, each log calibrated in both forms."""
    return Experiment(partial(score_forms, das=das), PAPER_MANEUVERS, (turbulence,), FORMS, "form")


def score_forms(trial: Trial, forms: tuple[str, ...], das: str) -> list[Row]:
    """Fly once and calibrate in each form, with random constant errors of heading and vanes; one row a form."""
    flight = bench.fly(random_case(trial))
    return list(_rows(trial, forms, flight, _turned(bench.sense(flight, das), trial.seed)))


def _turned(log: FlightLog, seed: int) -> FlightLog:
    off = np.random.default_rng([seed, 80]).standard_normal(3) * [_HEADING, _VANES, _VANES]
    if log.heading is None or log.sideslip is None or log.angle_of_attack is None:
        raise ValueError("a synthetic log has attitude and flow angles")
    return replace(
        log,
        heading=log.heading + off[0],
        sideslip=log.sideslip + off[1],
        angle_of_attack=log.angle_of_attack + off[2],
    )


def _rows(trial: Trial, forms: tuple[str, ...], flight: Flight, log: FlightLog) -> Iterator[Row]:
    for form in forms:
        base: Row = {"maneuver": trial.maneuver, "turbulence": trial.turbulence, "form": form, "seed": trial.seed}
        yield base | figures_of_log(log, bench.CalibrationOptions(form=form), flight)


def summarize_forms(rows: pd.DataFrame) -> pd.DataFrame:
    """Return one line for each maneuver and form: shares inside [%], mean 2σ and rms errors [kt] over seeds."""
    return over_seeds(rows, ("maneuver", "turbulence", "form"), ("", "wind "))
