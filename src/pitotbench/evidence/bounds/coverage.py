"""Measure how often the bounds contain the truth, over flights with random truth and noise of unknown level."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pandas as pd

from pitotbench import bench
from pitotbench.bench.flight_store import FlightStore
from pitotbench.bench.truth_comparison import compare_curve, compare_wind, rms, scored
from pitotbench.evidence.bounds.scorings import SCORINGS, Scoring
from pitotbench.evidence.experiment import Row, Trial
from pitotbench.evidence.random_truth import random_case
from pitotbench.records.calibration import Calibration
from pitotbench.records.errors import NoAnswerError
from pitotbench.records.flight import Flight
from pitotbench.units import KNOT, Array

TURBULENCE = ("none", "light", "moderate")


def score_trial(trial: Trial, scorings: tuple[str, ...], store: FlightStore | None = None) -> list[Row]:
    """Fly a trial once, sense it with every data system, calibrate it for every scoring; return a row for each."""
    case = random_case(trial)
    flight = bench.fly(case) if store is None else store.fly(case)
    return [row for name in scorings for row in _rows(trial, flight, SCORINGS[name])]


def _rows(trial: Trial, flight: Flight, scoring: Scoring) -> Iterator[Row]:
    flown, wind = scoring.in_wind(flight, trial.seed)
    cell: Row = {"scoring": scoring.name, "maneuver": trial.maneuver, "turbulence": trial.turbulence}
    for system in scoring.systems:
        log = scoring.with_errors(bench.sense(flown, system), trial.seed)
        base = cell | {"das": system, "seed": trial.seed}
        try:
            ours = bench.calibrate(log, scoring.options)
            paper = (
                bench.calibrate(log, bench.CalibrationOptions(method="paper")) if scoring.against_paper else ours
            )
        except NoAnswerError as error:
            yield base | {"failed": str(error)}
            continue
        yield base | {"failed": ""} | _figures(flown, wind, ours, paper)


def _figures(flight: Flight, wind: Array, ours: Calibration, paper: Calibration) -> Row:
    curve, truth, inside = ours.curve, flight.case.pressure_error, scored(ours.curve)
    found = compare_curve(curve, truth)
    return {
        "coverage": found.inside,
        "band_coverage": float(replace(found, two_sigma=curve.simultaneous_two_sigma[inside]).all_inside),
        "white_coverage": replace(found, two_sigma=curve.white_two_sigma[inside]).inside,
        "wind_coverage": compare_wind(ours.wind, wind).inside,
        "two_sigma_kt": found.mean_two_sigma / KNOT,
        "mean_error_kt": found.mean_error / KNOT,
        "rms_error_kt": found.rms_error / KNOT,
        "paper_rms_error_kt": compare_curve(paper.curve, truth).rms_error / KNOT,
        "residual_two_sigma_kt": ours.residual_two_sigma / KNOT,
        "finite": bool(np.all(np.isfinite(found.two_sigma)) and np.all(found.two_sigma > 0.0)),
    }


def summarize(rows: pd.DataFrame) -> pd.DataFrame:
    """Return one line for each cell: shares [%] with their standard errors, errors and bounds [kt]."""
    good = rows[rows["failed"] == ""]
    groups = good.groupby(["scoring", "maneuver", "turbulence", "das"], sort=False)
    table = pd.DataFrame({"flights": groups.size()})
    for name in ("coverage", "band_coverage", "wind_coverage", "white_coverage"):
        table[f"{name}_percent"] = 100.0 * groups[name].mean()
    table["coverage_se_percent"] = 100.0 * groups["coverage"].sem()
    table["two_sigma_kt"] = groups["two_sigma_kt"].mean()
    for name in ("rms_error_kt", "paper_rms_error_kt"):
        table[name] = groups[name].apply(rms)
    table["bias_kt"] = groups["mean_error_kt"].mean()
    table["bias_over_se"] = groups["mean_error_kt"].mean() / groups["mean_error_kt"].sem()
    table["residual_two_sigma_kt"] = groups["residual_two_sigma_kt"].mean()
    return table.reset_index()
