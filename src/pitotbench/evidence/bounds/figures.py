"""The figures of scored calibrations: shares inside the bounds, bounds and errors, of one log and over seeds."""

from collections.abc import Sequence

import pandas as pd

from pitotbench import bench
from pitotbench.bench.truth_comparison import compare_curve, compare_wind, rms
from pitotbench.records.calibration import Calibration
from pitotbench.records.errors import NoAnswerError
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT


def figures(result: Calibration, flight: Flight) -> dict[str, float]:
    """Return the figures of one calibration against the truth of its flight.

    They are the shares of the curve (100 to 160 KIAS) and of the wind's components inside 2σ [%], and the mean 2σ
    and the rms error of the curve and of the wind [kt].
    """
    curve = compare_curve(result.curve, flight.case.pressure_error)
    wind = compare_wind(result.wind, bench.wind_toward(flight.case.wind)[:2])
    return {
        "coverage_percent": 100.0 * curve.inside,
        "wind_coverage_percent": 100.0 * wind.inside,
        "two_sigma_kt": curve.mean_two_sigma / KNOT,
        "rms_error_kt": curve.rms_error / KNOT,
        "wind_two_sigma_kt": wind.mean_two_sigma / KNOT,
        "wind_rms_error_kt": wind.rms_error / KNOT,
    }


def figures_of_log(log: FlightLog, options: bench.CalibrationOptions, flight: Flight) -> dict[str, float]:
    """Return the figures of a log calibrated with these options; none where it does not determine the answer."""
    try:
        return figures(bench.calibrate(log, options), flight)
    except NoAnswerError:
        return {}


def over_seeds(rows: pd.DataFrame, by: Sequence[str], of: Sequence[str] = ("",)) -> pd.DataFrame:
    """Return one line for each group: shares inside [%], mean 2σ and rms error [kt].

    `of` chooses the curve ("") and the wind ("wind ") for the last two. `answers` is the number of calibrations
    that gave an answer.
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
