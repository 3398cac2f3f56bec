"""Forecasts compared with flights: a picture and a Markdown page."""

from operator import itemgetter
from pathlib import Path
from typing import Any

import pandas as pd

from pitotbench.show.columns import Column, frame_rows, markdown_table
from pitotbench.show.style import BLUE, GREEN, GREY, ORANGE, canvas

_COLORS = (BLUE, ORANGE, GREEN)
_WITHIN = (0.9, 1.1)
_TICKS = (0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5)  # kt


def _column(name: str, heading: str, unit: str = "", style: str = "") -> Column[dict[str, Any]]:
    return Column(heading, itemgetter(name), unit, style)


_COLUMNS = (
    _column("maneuver", "maneuver"),
    _column("turbulence", "turbulence"),
    _column("das", "DAS", "Hz"),
    _column("flights", "flights", style="d"),
    _column("minutes", "time", "min", ".1f"),
    _column("predicted_kt", "predicted ±2σ", "kt", ".3f"),
    _column("flown_kt", "flown ±2σ", "kt", ".3f"),
    _column("flown_se_kt", "standard error", "kt", ".3f"),
    _column("ratio", "predicted / flown", style=".2f"),
    _column("per_step_decrease", "flown / Step Decrease, equal minutes", style=".2f"),
    _column("error_kt", "true rms error", "kt", ".3f"),
    _column("coverage", "curve inside ±2σ", "%", ".0%"),
)
_HEIGHT_COLUMNS = (
    _column("maneuver", "maneuver"),
    _column("receiver", "used of the receiver"),
    _column("flights", "flights", style="d"),
    _column("predicted_kt", "predicted ±2σ", "kt", ".3f"),
    _column("flown_kt", "flown ±2σ", "kt", ".3f"),
    _column("flown_se_kt", "standard error", "kt", ".3f"),
    _column("ratio", "predicted / flown", style=".2f"),
    _column("predicted_share", "predicted / triangle alone", style=".2f"),
    _column("flown_share", "flown / triangle alone", style=".2f"),
    _column("coverage", "curve inside ±2σ", "%", ".0%"),
    _column("two_sigma_ft", "position error ±2σ", "ft", ".1f"),
    _column("coverage_ft", "position error inside ±2σ", "%", ".0%"),
)
_HEIGHTS = """
## An error of the static source

GPS height shows an error of the static source too (the altitude equation, [method.md](method.md)). The same
comparison at 3,350 ft in light turbulence (0.5 m/s), 20/1 Hz, with a receiver that stands alone. Its height has a
white error of 0.3 m and a slow one of 2 m over 90 s, its velocity a white one of 0.05 m/s. *Triangle* uses neither
the height nor the vertical velocity. (Its bounds are two to three times those above: the gusts are 2.6 times as
strong here.) {flights} flights a cell (seeds from 1);
`python scripts/check_plan.py --height-only` prints this table.

{verdict}

{table}
"""
_PAGE = """# What to fly: forecasts against flights

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
## How a forecast is made

1. The card is flown once in smooth air, in the expected wind.
2. Dryden gusts (MIL-F-8785C) of the expected level are drawn along its path, 16 times by default. As in the
   simulator, the gust field is fixed to the ground and has the same axes. The gusts change the air data, not the
   ground velocity.
3. The data system records each draw, and the calibrator, which has to estimate the level and the length of the
   gusts, gives its bound. The mean over the draws is the forecast; their standard deviation is the difference
   to expect from flight to flight.

The search for a better card flies each trial card once. It minimizes the bound from the inverse information matrix
of that flight in smooth air, for gusts of known level; `--json` shows both bounds.

## Why turns

The bound comes from gusts, and a gust lasts for seconds. Take a first-order gust of variance σ² and time constant
T. Its mean over a long time t has the variance 2Tσ²/t on a steady heading, but only 2Tσ²/t/(1 + ω²T²) for an
airplane that turns at the rate ω, because the airplane turns relative to the gust. At 45° of bank, ωT is 0.6 at
160 KCAS and 1.6 at 100 KCAS. In turns, every speed also occurs on every heading, so the wind is known far better
than the curve.

Two cautions. The simulator's pressure error does not depend on the load factor; a real one may (the legs of the
cloverleaf and the two sides of the figure eight show a part of it). And the search does not change headings,
because the simulator's turbulence has an axis on the ground, which real air does not have.
"""


def add_reference(table: pd.DataFrame) -> pd.DataFrame:
    """The table with `per_step_decrease`: flown 2σ over that of Step Decrease, at equal minutes."""
    work = table.flown_kt * table.minutes**0.5
    keys = list(zip(table.turbulence, table.das, strict=True))
    steps = table.maneuver == "step_decrease"
    reference = {key: float(value) for key, value, is_step in zip(keys, work, steps, strict=True) if is_step}
    return table.assign(per_step_decrease=[w / reference[k] for w, k in zip(work, keys, strict=True)])


def check_picture(table: pd.DataFrame, path: Path) -> None:
    """Predicted against flown 2σ [kt] and their ratio, as PNG."""
    with canvas(1, 2, 11.0, 4.4) as (figure, (size, ratio)):
        for color, (das, rows) in zip(_COLORS, table.groupby("das", sort=False), strict=False):
            bars = 2.0 * rows.flown_se_kt
            size.errorbar(
                rows.predicted_kt, rows.flown_kt, yerr=bars, fmt="o", ms=4, color=color, label=f"{das} Hz"
            )
            names = rows.maneuver.str.replace("_", " ") + ", " + rows.turbulence
            ratio.errorbar(
                rows.ratio, names, xerr=rows.ratio * bars / rows.flown_kt, fmt="o", ms=4, color=color, alpha=0.8
            )
        ends = [0.8 * table.predicted_kt.min(), 1.2 * table.predicted_kt.max()]
        size.plot(ends, ends, color=GREY, lw=0.8)
        size.set(
            xscale="log", yscale="log", xlabel="predicted ±2σ [kt]", ylabel="flown ±2σ, with 2 standard errors [kt]"
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
    """The Markdown page of a table with `add_reference`, and of a table of `height_check.check_height`."""
    lines = markdown_table(_COLUMNS, frame_rows(table))
    section = "" if heights is None else _height_section(heights)
    return _PAGE.format(provenance=provenance, verdict=_verdict(table), table=lines, heights=section)


def _height_section(heights: pd.DataFrame) -> str:
    """The section about an error of the static source, which GPS height shows too."""
    low, high = _WITHIN
    inside = int(heights.ratio.between(low, high).sum())
    verdict = (
        f"Predicted / flown ±2σ: {heights.ratio.min():.2f} to {heights.ratio.max():.2f}; "
        f"{inside} of {len(heights)} cells within {low} to {high}."
    )
    flights = int(heights.flights.min())
    rows = frame_rows(heights.astype(object).where(heights.notna(), None))  # the triangle has no share of itself
    return _HEIGHTS.format(flights=flights, verdict=verdict, table=markdown_table(_HEIGHT_COLUMNS, rows))


def _verdict(table: pd.DataFrame) -> str:
    low, high = _WITHIN
    inside = int(table.ratio.between(low, high).sum())
    best = table.sort_values("per_step_decrease").iloc[0]
    return (
        f"Predicted / flown ±2σ: {table.ratio.min():.2f} to {table.ratio.max():.2f}, "
        f"mean {table.ratio.mean():.2f}; {inside} of {len(table)} cells within {low} to {high}.\n"
        f"The smallest bound for equal minutes: {best.maneuver} at {best.das} Hz, turbulence {best.turbulence}, "
        f"with {best.per_step_decrease:.2f} times the ±2σ of Step Decrease."
    )
