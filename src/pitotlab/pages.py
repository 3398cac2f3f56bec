"""The pages of measured numbers (Markdown), and their pictures."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pandas as pd

from pitotbench.show.columns import frame_rows, keyed
from pitotbench.show.style import BLUE, GREEN, GREY, ORANGE, canvas
from pitotlab.tables import frame_columns, markdown_table

_NOMINAL = 95.0  # percent, the coverage of a ±2σ bound


_COVERAGE_COLUMNS = (
    keyed("maneuver", "maneuver"),
    keyed("turbulence", "turbulence"),
    keyed("das", "DAS", "Hz"),
    keyed("coverage_percent", "curve inside ±2σ", "%", ".1f"),
    keyed("coverage_se_percent", "its standard error", "%", ".1f"),
    keyed("band_coverage_percent", "whole curve inside its band", "%", ".1f"),
    keyed("wind_coverage_percent", "wind inside ±2σ", "%", ".1f"),
    keyed("white_coverage_percent", "curve inside ±2σ for white residuals", "%", ".1f"),
    keyed("two_sigma_kt", "mean ±2σ", "kt", ".3f"),
    keyed("rms_error_kt", "true rms error", "kt", ".3f"),
    keyed("paper_rms_error_kt", "rms error of the paper's method", "kt", ".3f"),
    keyed("bias_kt", "mean error", "kt", ".3f"),
    keyed("bias_over_se", "mean error / its standard error", style=".1f"),
)
_COVERAGE_PAGE = """# How often the true curve lies inside the bound

{provenance}

Every flight has a random wind up to 25 kt from any direction and a random Inverse+ pressure error; the log is
calibrated with Inverse+, with the noise unknown to the estimator. A cell's share is over all points of the curve
from 100 to 160 KIAS and over all flights; its standard error is that over flights. `make lab-verify` repeats it.

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
            cells.white_coverage_percent,
            place,
            "x",
            color=ORANGE,
            ms=4,
            label="curve, 2σ for white residuals",
        )
        share.plot(cells.wind_coverage_percent, place, ".", color=GREY, ms=5, label="wind, ±2σ")
        share.set_yticks(place, labels, fontsize=7)
        share.set(title="Share inside the bound", xlabel="share [%]", xlim=(0.0, 101.0))
        share.legend(loc="center", fontsize=7.5)
        size.plot(
            2.0 * cells.rms_error_kt, place, "o", ms=4, color=ORANGE, label="2 × true rms error"
        )
        size.plot(cells.two_sigma_kt, place, "o", ms=4, color=BLUE, label="mean ±2σ")
        size.plot(
            2.0 * cells.paper_rms_error_kt,
            place,
            "x",
            ms=4,
            color=GREY,
            label="2 × rms error, paper's method",
        )
        size.set_yticks(place, [])
        size.set(title="Bound and true error", xlabel="airspeed [kt]", xscale="log")
        size.legend(loc="best", fontsize=7.5)
        figure.savefig(path, dpi=110)


def coverage_page(cells: pd.DataFrame, provenance: str) -> str:
    """The Markdown page: the flights, the picture, and every cell in numbers."""
    first = cells[cells.scoring == cells.scoring.iloc[0]]
    groups = cells.groupby("scoring", sort=False)
    return _COVERAGE_PAGE.format(
        provenance=provenance,
        verdicts="\n".join(f"- {name}: {_coverage_verdict(group)}" for name, group in groups),
        ratio=rate_ratio(first),
        better=int((first.rms_error_kt < first.paper_rms_error_kt).sum()),
        worse=100.0 * float((first.rms_error_kt / first.paper_rms_error_kt - 1.0).max()),
        cells=len(first),
        tables="\n\n".join(
            f"## {str(name).capitalize()}\n\n{_table(group)}" for name, group in groups
        ),
    )


def rate_ratio(cells: pd.DataFrame) -> float:
    """Mean bound at 20/1 Hz over that at 50/50 Hz, of the cells in turbulence."""
    rough = (
        cells[cells.turbulence != "none"].set_index(["das", "maneuver", "turbulence"]).two_sigma_kt
    )
    return float((rough.loc["20/1"] / rough.loc["50/50"]).mean())


def _coverage_verdict(cells: pd.DataFrame) -> str:
    share, band = cells.coverage_percent, cells.band_coverage_percent
    within = int((np.abs(share - _NOMINAL) <= 2.0).sum())
    return (
        f"{cells.flights.min()} flights a cell, {share.min():.1f} to {share.max():.1f} % of the "
        "curve over "
        f"{len(cells)} cells, mean {share.mean():.1f}; "
        f"{within} within 95 ± 2 %; whole curves inside their band {band.min():.1f} to "
        f"{band.max():.1f} %"
    )


def _table(cells: pd.DataFrame) -> str:
    return markdown_table(_COVERAGE_COLUMNS, frame_rows(cells))


_SYSTEM_COLORS = (BLUE, ORANGE, GREEN)
_WITHIN = (0.9, 1.1)
_TICKS = (0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5)  # kt


_BOUNDS = (
    keyed("predicted_kt", "predicted ±2σ", "kt", ".3f"),
    keyed("flown_kt", "flown ±2σ", "kt", ".3f"),
    keyed("flown_se_kt", "standard error", "kt", ".3f"),
    keyed("ratio", "predicted / flown", style=".2f"),
)
_PLAN_COLUMNS = (
    keyed("maneuver", "maneuver"),
    keyed("turbulence", "turbulence"),
    keyed("das", "DAS", "Hz"),
    keyed("flights", "flights", style="d"),
    keyed("minutes", "time", "min", ".1f"),
    *_BOUNDS,
    keyed("per_step_decrease", "flown / Step Decrease, equal minutes", style=".2f"),
    keyed("error_kt", "true rms error", "kt", ".3f"),
    keyed("coverage", "curve inside ±2σ", "%", ".0%"),
)
_HEIGHT_COLUMNS = (
    keyed("maneuver", "maneuver"),
    keyed("receiver", "used of the receiver"),
    keyed("flights", "flights", style="d"),
    *_BOUNDS,
    keyed("predicted_share", "predicted / triangle alone", style=".2f"),
    keyed("flown_share", "flown / triangle alone", style=".2f"),
    keyed("coverage", "curve inside ±2σ", "%", ".0%"),
    keyed("two_sigma_ft", "position error ±2σ", "ft", ".1f"),
    keyed("coverage_ft", "position error inside ±2σ", "%", ".0%"),
)
_HEIGHTS = """
## An error of the static source

GPS height shows an error of the static source too (the altitude equation of docs/method.md). The same
comparison at 3,350 ft in light turbulence (0.5 m/s), 20/1 Hz, with a receiver that stands alone. Its height has a
white error of 0.3 m and a slow one of 2 m over 90 s, its velocity a white one of 0.05 m/s. *Triangle* uses neither
the height nor the vertical velocity. (Its bounds are two to three times those above: the gusts are 2.6 times as
strong here.) {flights} flights a cell (seeds from 1);
`python -m pitotlab plan --height-only` prints this table.

{verdict}

{table}
"""
_PLAN_PAGE = """# What to fly: forecasts against flights

{provenance}

`pitotbench plan` forecasts, before a flight, how well the curve will be known. Here every maneuver was then flown
in JSBSim's turbulence and calibrated, with the noise unknown to the calibrator. ±2σ is the mean over 100 to
160 KIAS; the standard error is that of the flown mean. *Flown / Step Decrease, equal minutes* is the ratio of the
flown ±2σ to that of Step Decrease with the same data system; both are scaled to equal minutes by the square root
of time. All flights are at 6,000 ft, where light turbulence is 0.19 m/s (1σ) and moderate 0.72 m/s, and the error
acts on the impact pressure alone.

{verdict}

![Predicted and flown 2σ](plan.png)

{table}
{heights}
"""


def add_reference(table: pd.DataFrame) -> pd.DataFrame:
    """The table with `per_step_decrease`: flown 2σ over that of Step Decrease, at equal minutes."""
    work = table.flown_kt * table.minutes**0.5
    keys = list(zip(table.turbulence, table.das, strict=True))
    steps = table.maneuver == "step_decrease"
    reference = {
        key: float(value) for key, value, is_step in zip(keys, work, steps, strict=True) if is_step
    }
    return table.assign(
        per_step_decrease=[w / reference[k] for w, k in zip(work, keys, strict=True)]
    )


def check_picture(table: pd.DataFrame, path: Path) -> None:
    """Predicted against flown 2σ [kt] and their ratio, as PNG."""
    with canvas(1, 2, 11.0, 4.4) as (figure, (size, ratio)):
        for color, (das, rows) in zip(
            _SYSTEM_COLORS, table.groupby("das", sort=False), strict=False
        ):
            bars = 2.0 * rows.flown_se_kt
            size.errorbar(
                rows.predicted_kt,
                rows.flown_kt,
                yerr=bars,
                fmt="o",
                ms=4,
                color=color,
                label=f"{das} Hz",
            )
            names = rows.maneuver.str.replace("_", " ") + ", " + rows.turbulence
            ratio.errorbar(
                rows.ratio,
                names,
                xerr=rows.ratio * bars / rows.flown_kt,
                fmt="o",
                ms=4,
                color=color,
                alpha=0.8,
            )
        ends = [0.8 * table.predicted_kt.min(), 1.2 * table.predicted_kt.max()]
        size.plot(ends, ends, color=GREY, lw=0.8)
        size.set(
            xscale="log",
            yscale="log",
            xlabel="predicted ±2σ [kt]",
            ylabel="flown ±2σ, with 2 standard errors [kt]",
        )
        for axis in (size.xaxis, size.yaxis):
            axis.set_ticks(_TICKS, [f"{tick:g}" for tick in _TICKS])
            axis.set_ticks([], minor=True)
        size.set(xlim=ends, ylim=ends)
        size.legend()
        ratio.axvspan(*_WITHIN, color="#E3F1E9")
        ratio.set(xlabel="predicted / flown ±2σ")
        ratio.invert_yaxis()
        figure.savefig(path, dpi=110)


def check_page(table: pd.DataFrame, provenance: str, heights: pd.DataFrame | None = None) -> str:
    """The Markdown page of a table with `add_reference`, and of one of
    `check_forecasts_with_height`.
    """
    lines = markdown_table(_PLAN_COLUMNS, frame_rows(table))
    section = "" if heights is None else _height_section(heights)
    return _PLAN_PAGE.format(
        provenance=provenance, verdict=_plan_verdict(table), table=lines, heights=section
    )


def _height_section(heights: pd.DataFrame) -> str:
    """The section about an error of the static source, which GPS height shows too."""
    verdict = f"Predicted / flown ±2σ: {_range(heights)}; {_inside(heights)}."
    flights = int(heights.flights.min())
    rows = frame_rows(
        heights.astype(object).where(heights.notna(), None)
    )  # the triangle has no share of itself
    return _HEIGHTS.format(
        flights=flights, verdict=verdict, table=markdown_table(_HEIGHT_COLUMNS, rows)
    )


def _range(table: pd.DataFrame) -> str:
    return f"{table.ratio.min():.2f} to {table.ratio.max():.2f}"


def _inside(table: pd.DataFrame) -> str:
    low, high = _WITHIN
    return (
        f"{int(table.ratio.between(low, high).sum())} of {len(table)} cells within {low} to {high}"
    )


def _plan_verdict(table: pd.DataFrame) -> str:
    best = table.sort_values("per_step_decrease").iloc[0]
    return (
        f"Predicted / flown ±2σ: {_range(table)}, mean {table.ratio.mean():.2f}; "
        f"{_inside(table)}.\n"
        f"The smallest bound for equal minutes: {best.maneuver} at {best.das} Hz, turbulence "
        f"{best.turbulence}, "
        f"with {best.per_step_decrease:.2f} times the ±2σ of Step Decrease."
    )


_PEERS = """# The bound compared with published ones

Every row is fitted to the same flights: {count} a maneuver (seeds {first} to {last}, {date:%Y-%m-%d}), light
turbulence, random wind and Inverse+ error. `python -m pitotlab peers --seeds {count}` repeats it. A ±2σ
bound should contain 95 % of the curve.

- *white residuals*: Cramér-Rao bound of output error for uncorrelated residuals (Klein and Morelli 2006).
- *colored residuals, all lags*: that bound with the autocorrelation of the residual (Morelli and Klein 1997).
- *HAC*: the same with a Bartlett window (Newey and West 1987).
- *1 Hz filter of wind and scale*: an extended Kalman filter as small autopilots run it.
- *per-point spread, fixed speed*: legs or turns at one speed each, bounded by twice their scatter (points, not the
  whole curve; no row where a maneuver holds no speed).
- *pitotbench*: `two_sigma_kt`. For the last row the noise's levels and length are given, not estimated.

`python -m pitotlab speed packages` tells what some of them cost.

{table}

Because it has to estimate the noise, the bound is {sharpness:.2f} times as wide as for known noise.
"""
_AUTO = """# `--model auto` on curves that no model of the table can represent

Every flight is recorded with {truths} truths ({names}), their parameters random. Seeds {first} to {last},
{turbulence} turbulence, {das} Hz, {date:%Y-%m-%d}. A ±2σ bound should contain 95 % of the curve.
`python -m pitotlab auto --maneuver {maneuver} --seeds {count} --first {first}` repeats it.

{table}
"""


def peers_page(table: pd.DataFrame, seeds: Sequence[int]) -> str:
    """The bounds of published methods and of pitotbench, as Markdown."""
    wide = table.pivot_table(index=["maneuver", "das"], columns="bound", values="mean 2σ [kt]")
    sharpness = float((wide["pitotbench"] / wide["pitotbench, if the noise were known"]).mean())
    return _PEERS.format(table=_markdown(table), sharpness=sharpness, **_flown(seeds))


def auto_page(
    table: pd.DataFrame, truths: Sequence[str], seeds: Sequence[int], asked: Mapping[str, str]
) -> str:
    """Models weighed on truths outside their table, as Markdown; `asked` holds maneuver, turbulence
    and das.
    """
    names = ", ".join(truths)
    return _AUTO.format(
        table=_markdown(table), truths=len(truths), names=names, **asked, **_flown(seeds)
    )


def _flown(seeds: Sequence[int]) -> dict[str, object]:
    return {"count": len(seeds), "first": seeds[0], "last": seeds[-1], "date": datetime.now(UTC)}


def _markdown(table: pd.DataFrame) -> str:
    """A frame as a Markdown table, its columns' names as headings, numbers with three digits."""
    return markdown_table(frame_columns(table, ".3g"), frame_rows(table))
