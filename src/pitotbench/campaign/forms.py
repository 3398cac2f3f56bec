"""Scalar and vector form on the same flights, with heading and vanes off: what attitude and flow angles add."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pandas as pd

from pitotbench import bench
from pitotbench.calibrate.options import FORMS
from pitotbench.campaign.coverage import Trial
from pitotbench.records.calibration import Calibration
from pitotbench.records.errors import NoAnswerError
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT

FIRST_SCORED_SEED = 300_001
_HEADING, _VANES = np.radians(1.0), np.radians(0.5)  # standard deviations of constant errors


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
        try:
            result = bench.calibrate(log, bench.CalibrationOptions(form=form))
        except NoAnswerError:
            yield base
            continue
        yield base | _figures(result, flight)


def _figures(result: Calibration, flight: Flight) -> dict[str, float]:
    score = bench.score(result, flight)
    wind = np.array([result.wind.north.value, result.wind.east.value]) - bench.wind_toward(flight.case.wind)[:2]
    bound = np.array([result.wind.north.two_sigma, result.wind.east.two_sigma])
    return {
        "coverage": 100.0 * score.curve_coverage,
        "wind_coverage": 100.0 * float(np.mean(np.abs(wind) <= bound)),
        "two_sigma": score.two_sigma / KNOT,
        "squared_error": (score.curve_rms_error / KNOT) ** 2,
        "wind_two_sigma": float(np.mean(bound)) / KNOT,
        "wind_squared_error": float(np.mean(wind**2)) / KNOT**2,
    }


def summarize_forms(rows: pd.DataFrame) -> pd.DataFrame:
    """One line a maneuver and form: shares inside [%], mean 2σ and rms errors [kt] over seeds."""
    groups = rows.groupby(["maneuver", "turbulence", "form"], sort=False)
    mean, table = groups.mean(numeric_only=True), pd.DataFrame({"answers": groups["coverage"].count()})
    table["curve inside 2σ [%]"] = mean["coverage"]
    table["± [%]"] = groups["coverage"].sem()
    table["wind inside 2σ [%]"] = mean["wind_coverage"]
    table["mean 2σ [kt]"] = mean["two_sigma"]
    table["rms error [kt]"] = np.sqrt(mean["squared_error"])
    table["wind 2σ [kt]"] = mean["wind_two_sigma"]
    table["wind rms error [kt]"] = np.sqrt(mean["wind_squared_error"])
    return table.reset_index()
