"""The coverage campaign as a picture and a page: the share of true curves inside the bound, in every cell."""

from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pitotbench.show.columns import Column, frame_rows, markdown_table
from pitotbench.show.style import BLUE, GREY, ORANGE, canvas

_NOMINAL = 95.0  # percent, the coverage of a ±2σ bound


def _column(name: str, heading: str, unit: str = "", style: str = "") -> Column[dict[str, Any]]:
    return Column(heading, itemgetter(name), unit, style)


_COLUMNS = (
    _column("maneuver", "maneuver"),
    _column("turbulence", "turbulence"),
    _column("das", "DAS", "Hz"),
    _column("coverage_percent", "curve inside ±2σ", "%", ".1f"),
    _column("coverage_se_percent", "its standard error", "%", ".1f"),
    _column("band_coverage_percent", "whole curve inside its band", "%", ".1f"),
    _column("wind_coverage_percent", "wind inside ±2σ", "%", ".1f"),
    _column("white_coverage_percent", "curve inside ±2σ for white residuals", "%", ".1f"),
    _column("two_sigma_kt", "mean ±2σ", "kt", ".3f"),
    _column("rms_error_kt", "true rms error", "kt", ".3f"),
    _column("paper_rms_error_kt", "rms error of the paper's method", "kt", ".3f"),
    _column("bias_kt", "mean error", "kt", ".3f"),
    _column("bias_over_se", "mean error / its standard error", style=".1f"),
)
_PAGE = """# How often the true curve lies inside the bound

{provenance}

Every flight has a random wind up to 25 kt from any direction and a random Inverse+ pressure error; the log is
calibrated with Inverse+, with the noise unknown to the estimator. A cell's share is over all points of the curve
from 100 to 160 KIAS and over all flights; its standard error is that over flights. `make verify` repeats it.

- *constant wind*: nothing but gusts and the sensors' noise.
- *systematic errors*: temperature, recovery factor, static pressure and GPS velocity are off by constant errors,
  drawn from the accuracies that are stated to the calibrator.
- *slow wind*: the wind is a random walk, 1 m/s rms in ten minutes; calibrated with `--wind drifting`.

{verdicts}

The bound at 20/1 Hz is {ratio:.3f} times that at 50/50 Hz, on the same flights (mean over maneuvers in turbulence).
The true rms error is below that of the paper's method in {better} of {cells} cells; where above, by
{worse:.1f} % at most.

![Coverage map](coverage.png)

{tables}
"""


def coverage_picture(cells: pd.DataFrame, path: Path) -> None:
    """Coverage of every cell of the first scoring, and the bound against the true error, as PNG."""
    cells = cells[cells.scoring == cells.scoring.iloc[0]]
    labels = [
        f"{m.replace('_', ' ')}, {t}, {d}"
        for m, t, d in zip(cells.maneuver, cells.turbulence, cells.das, strict=True)
    ]
    place = np.arange(len(cells))[::-1]
    with canvas(1, 2, 12.0, 0.19 * len(cells) + 1.4) as (figure, (share, size)):
        share.axvspan(_NOMINAL - 2.0, _NOMINAL + 2.0, color="#E3F1E9", label="95 ± 2 %")
        share.errorbar(
            cells.coverage_percent,
            place,
            xerr=2.0 * cells.coverage_se_percent,
            fmt="o",
            ms=4,
            color=BLUE,
            label="curve, ±2σ",
        )
        share.plot(
            cells.white_coverage_percent, place, "x", color=ORANGE, ms=4, label="curve, 2σ for white residuals"
        )
        share.plot(cells.wind_coverage_percent, place, ".", color=GREY, ms=5, label="wind, ±2σ")
        share.set_yticks(place, labels, fontsize=7)
        share.set(title="Share inside the bound", xlabel="share [%]", xlim=(0.0, 101.0))
        share.legend(loc="center", fontsize=7.5)
        size.plot(2.0 * cells.rms_error_kt, place, "o", ms=4, color=ORANGE, label="2 × true rms error")
        size.plot(cells.two_sigma_kt, place, "o", ms=4, color=BLUE, label="mean ±2σ")
        size.plot(
            2.0 * cells.paper_rms_error_kt, place, "x", ms=4, color=GREY, label="2 × rms error, paper's method"
        )
        size.set_yticks(place, [])
        size.set(title="Bound and true error", xlabel="airspeed [kt]", xscale="log")
        size.legend(loc="best", fontsize=7.5)
        figure.savefig(path, dpi=110)


def coverage_page(cells: pd.DataFrame, provenance: str) -> str:
    """The Markdown page: the flights, the picture, and every cell in numbers."""
    first = cells[cells.scoring == cells.scoring.iloc[0]]
    groups = cells.groupby("scoring", sort=False)
    return _PAGE.format(
        provenance=provenance,
        verdicts="\n".join(f"- {name}: {_verdict(group)}" for name, group in groups),
        ratio=rate_ratio(first),
        better=int((first.rms_error_kt < first.paper_rms_error_kt).sum()),
        worse=100.0 * float((first.rms_error_kt / first.paper_rms_error_kt - 1.0).max()),
        cells=len(first),
        tables="\n\n".join(f"## {str(name).capitalize()}\n\n{_table(group)}" for name, group in groups),
    )


def rate_ratio(cells: pd.DataFrame) -> float:
    """Mean bound at 20/1 Hz over that at 50/50 Hz, of the cells in turbulence."""
    rough = cells[cells.turbulence != "none"].set_index(["das", "maneuver", "turbulence"]).two_sigma_kt
    return float((rough.loc["20/1"] / rough.loc["50/50"]).mean())


def _verdict(cells: pd.DataFrame) -> str:
    share, band = cells.coverage_percent, cells.band_coverage_percent
    within = int((np.abs(share - _NOMINAL) <= 2.0).sum())
    return (
        f"{cells.flights.min()} flights a cell, {share.min():.1f} to {share.max():.1f} % of the curve over "
        f"{len(cells)} cells, mean {share.mean():.1f}; "
        f"{within} within 95 ± 2 %; whole curves inside their band {band.min():.1f} to {band.max():.1f} %"
    )


def _table(cells: pd.DataFrame) -> str:
    return markdown_table(_COLUMNS, frame_rows(cells))
