"""The judge's table: one line a cell, from one row a flight."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from tests.outside.compressible import Array

TOLD = 0.9545  # the share of the curve that ±2σ is meant to contain; a flight with less is outside
FORMS = ("text", "markdown")
_SHORT = {
    "step_decrease": "step",
    "rapid_decel": "rapid",
    "circle": "circle",
    "race_track": "race",
    "four_leg": "four",
}


def table(rows: Sequence[Mapping[str, Any]], form: str = "text") -> str:
    """One line a cell: coverage with its standard error over flights, bound over oracle, share warned.

    `/oracle` is the mean of the bound over that of the triangle alone, `/joined` over that of both equations; both
    oracles allow for the usual constant errors of the sensors, as the calibration does. `ft` is the position error,
    which `ft given` flights have. `outside` counts
    the flights with less than 95.45 % of their curve inside the bound.
    """
    cells = list(dict.fromkeys(row["cell"] for row in rows))
    lines = [line_of([row for row in rows if row["cell"] == cell]) for cell in cells]
    columns = list(lines[0])
    body = [[line[column] for column in columns] for line in lines]
    if form == "markdown":
        ruled = [columns, ["---"] * len(columns), *body]
        return "\n".join("| " + " | ".join(cells) + " |" for cells in ruled)
    widths = [max(len(text) for text in column) for column in zip(columns, *body, strict=True)]
    return "\n".join(
        "  ".join(text.rjust(width) for text, width in zip(cells, widths, strict=True))
        for cells in (columns, *body)
    )


def line_of(rows: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """The line of one cell; a number that no flight gives is a dash."""
    answered = [row for row in rows if row["outcome"] == "answered"]
    coverage = 100.0 * _column(answered, "curve_coverage")
    bound, error = _column(answered, "two_sigma_kt"), _column(answered, "rms_error_kt")
    outside = [row for row in answered if row["curve_coverage"] < TOLD]
    rms = float(np.sqrt(np.mean(error**2))) if len(error) else float("nan")
    return {
        "cell": rows[0]["cell"],
        "n": str(len(answered)),
        "refused": str(sum(row["outcome"] == "refused" for row in rows)),
        "crashed": str(sum(row["outcome"] == "crashed" for row in rows)),
        "curve %": _text(_mean(coverage), 1),
        "±": _text(standard_error(coverage), 1),
        "whole %": _text(100.0 * _mean(_column(answered, "whole_band")), 0),
        "wind %": _text(100.0 * _mean(_column(answered, "wind_inside")), 0),
        "2σ kt": _text(_mean(bound), 3),
        "rms kt": _text(rms, 3),
        "mean kt": _text(_mean(_column(answered, "mean_error_kt")), 3),
        "2σ/2rms": _text(_mean(bound) / (2.0 * rms) if rms else float("nan"), 2),
        "/oracle": _text(_mean(bound / _column(answered, "oracle_two_sigma_kt")), 2),
        "/joined": _text(_mean(bound / _column(answered, "joined_two_sigma_kt")), 2),
        "ft %": _text(100.0 * _mean(_given(answered, "coverage_ft")), 1),
        "2σ ft": _text(_mean(_given(answered, "two_sigma_ft")), 1),
        "ft given": str(len(_given(answered, "coverage_ft"))),
        "warned %": _text(100.0 * _mean(_column(answered, "warned")), 0),
        "outside": str(len(outside)),
        "warned of these %": _text(100.0 * _mean(_column(outside, "warned")), 0),
        "by maneuver %": _by_maneuver(answered),
    }


def standard_error(values: Array) -> float:
    """Standard error of the mean over flights; NaN for fewer than two."""
    return float(np.std(values, ddof=1) / np.sqrt(len(values))) if len(values) > 1 else float("nan")


def _by_maneuver(rows: Sequence[Mapping[str, Any]]) -> str:
    shares = {
        short: 100.0 * _mean(_column([row for row in rows if row["maneuver"] == name], "curve_coverage"))
        for name, short in _SHORT.items()
    }
    return ", ".join(f"{name} {share:.0f}" for name, share in shares.items() if np.isfinite(share)) or "–"


def _column(rows: Sequence[Mapping[str, Any]], name: str) -> Array:
    return np.array([row[name] for row in rows], dtype=np.float64)


def _given(rows: Sequence[Mapping[str, Any]], name: str) -> Array:
    """The values of a column without those that are missing."""
    values = _column(rows, name)
    return values[np.isfinite(values)]


def _mean(values: Array) -> float:
    return float(np.mean(values)) if len(values) else float("nan")


def _text(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if np.isfinite(value) else "–"
