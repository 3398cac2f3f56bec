"""The coverage campaign as a map and a page: does the bound hold what it promises, in every cell?"""

from pathlib import Path

import numpy as np
import pandas as pd

from pitotbench.show.markup import markdown_table
from pitotbench.show.style import BLUE, GREY, ORANGE, canvas

_PROMISE = 95.0  # percent
_COLUMNS = {
    "maneuver": "maneuver",
    "turbulence": "turbulence",
    "das": "DAS [Hz]",
    "coverage_percent": "curve inside 2σ [%]",
    "coverage_se_percent": "± [%]",
    "band_coverage_percent": "whole curve inside its band [%]",
    "wind_coverage_percent": "wind inside 2σ [%]",
    "white_coverage_percent": "inside white 2σ [%]",
    "two_sigma_kt": "mean 2σ [kt]",
    "rms_error_kt": "true rms error [kt]",
    "paper_rms_error_kt": "paper's method, rms error [kt]",
    "bias_kt": "mean error [kt]",
    "bias_over_se": "mean error / its SE [-]",
}
_PAGE = """# Do the bounds cover?

{provenance}

Every flight has a random wind up to 25 kt from any direction and a random Inverse+ pressure error; the log is
calibrated with Inverse+, with the noise unknown to the estimator. A cell's share is over all points of the curve
from 100 to 160 KIAS and over all flights; ± is its standard error over flights. `make verify` repeats it.

- *constant wind*: nothing but gusts and the sensors' noise.
- *systematic errors*: temperature, recovery factor, static pressure and GPS velocity are off by constant errors,
  drawn from the accuracies that the calibrator is told.
- *slow wind*: the wind walks at random, 1 m/s rms in ten minutes; calibrated with `--wind drifting`.

{verdicts}

The bound at 20/1 Hz is {ratio:.3f} times that at 50/50 Hz, on the same flights (mean over maneuvers in turbulence).
The true rms error is below that of the paper's method in {better} of {cells} cells; where above, by
{worse:.1f} % at most.

![Coverage map](coverage.png)

{tables}
"""
_TWO_DIGITS = {"two_sigma_kt", "rms_error_kt", "paper_rms_error_kt", "bias_kt"}


def coverage_picture(cells: pd.DataFrame, path: Path) -> None:
    """Coverage of every cell of the first scoring, and the bound against the true error, as PNG."""
    cells = cells[cells.scoring == cells.scoring.iloc[0]]
    labels = [
        f"{m.replace('_', ' ')}, {t}, {d}"
        for m, t, d in zip(cells.maneuver, cells.turbulence, cells.das, strict=True)
    ]
    place = np.arange(len(cells))[::-1]
    with canvas(1, 2, 12.0, 0.19 * len(cells) + 1.4) as (figure, (share, size)):
        share.axvspan(_PROMISE - 2.0, _PROMISE + 2.0, color="#E3F1E9", label="95 ± 2 %")
        share.errorbar(
            cells.coverage_percent,
            place,
            xerr=2.0 * cells.coverage_se_percent,
            fmt="o",
            ms=4,
            color=BLUE,
            label="curve, 2σ",
        )
        share.plot(cells.white_coverage_percent, place, "x", color=ORANGE, ms=4, label="curve, white 2σ")
        share.plot(cells.wind_coverage_percent, place, ".", color=GREY, ms=5, label="wind, 2σ")
        share.set_yticks(place, labels, fontsize=7)
        share.set(title="Share inside the bound", xlabel="[%]", xlim=(0.0, 101.0))
        share.legend(loc="center", fontsize=7.5)
        size.plot(2.0 * cells.rms_error_kt, place, "o", ms=4, color=ORANGE, label="2 x true rms error")
        size.plot(cells.two_sigma_kt, place, "o", ms=4, color=BLUE, label="mean 2σ")
        size.plot(
            2.0 * cells.paper_rms_error_kt, place, "x", ms=4, color=GREY, label="2 x rms error, paper's method"
        )
        size.set_yticks(place, [])
        size.set(title="Bound and true error", xlabel="[kt]", xscale="log")
        size.legend(loc="best", fontsize=7.5)
        figure.savefig(path, dpi=110)


def coverage_page(cells: pd.DataFrame, provenance: str) -> str:
    """The Markdown page: what was flown, the map, every cell in numbers."""
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
    within = int((np.abs(share - _PROMISE) <= 2.0).sum())
    return (
        f"{cells.flights.min()} flights a cell, {share.min():.1f} to {share.max():.1f} % of the curve over "
        f"{len(cells)} cells, mean {share.mean():.1f}; "
        f"{within} within 95 ± 2 %; whole curves inside their band {band.min():.1f} to {band.max():.1f} %"
    )


def _table(cells: pd.DataFrame) -> str:
    rows = ([_cell(row[name], name) for name in _COLUMNS] for _, row in cells.iterrows())
    return markdown_table(list(_COLUMNS.values()), rows)


def _cell(value: object, name: str) -> str:
    if not isinstance(value, float):
        return str(value)
    return f"{value:.3f}" if name in _TWO_DIGITS else f"{value:.1f}"
