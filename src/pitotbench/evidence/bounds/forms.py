"""Scalar and vector form on the same flights, with heading and vanes off: what attitude and flow angles add."""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
from rich.console import Console
from rich.progress import track

from pitotbench import bench
from pitotbench.bench.campaign.perform import executor_for
from pitotbench.calibrate.options import FORMS
from pitotbench.evidence.bounds.coverage import Trial
from pitotbench.evidence.bounds.figures import over_seeds, scored
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.simulate import PAPER_MANEUVERS

FIRST_SCORED_SEED = 300_001
_HEADING, _VANES = np.radians(1.0), np.radians(0.5)  # standard deviations of constant errors


def score_all(seeds: Sequence[int], turbulence: str, das: str, jobs: int) -> list[dict[str, object]]:
    """Rows of all published maneuvers; a progress bar on a terminal."""
    flown = [Trial(maneuver, turbulence, seed) for seed in seeds for maneuver in PAPER_MANEUVERS]
    systems, quiet = [das] * len(flown), not sys.stderr.isatty()
    with executor_for(jobs, None) as pool:
        results = (map if pool is None else pool.map)(score_forms, flown, systems)
        done = track(results, "flights", len(flown), console=Console(stderr=True), disable=quiet)
        return [row for found in done for row in found]


def score_forms(trial: Trial, das: str) -> list[dict[str, object]]:
    """Fly once, calibrate in both forms, with heading and vanes off by random constants; one row a form."""
    flight = bench.fly(trial.case())
    return list(_rows(trial, flight, _turned(bench.sense(flight, das), trial.seed)))


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


def _rows(trial: Trial, flight: Flight, log: FlightLog) -> Iterator[dict[str, object]]:
    for form in FORMS:
        base = {"maneuver": trial.maneuver, "turbulence": trial.turbulence, "form": form, "seed": trial.seed}
        yield base | scored(log, bench.CalibrationOptions(form=form), flight)


def summarize_forms(rows: pd.DataFrame) -> pd.DataFrame:
    """One line a maneuver and form: shares inside [%], mean 2σ and rms errors [kt] over seeds."""
    return over_seeds(rows, ("maneuver", "turbulence", "form"), ("", "wind "))
