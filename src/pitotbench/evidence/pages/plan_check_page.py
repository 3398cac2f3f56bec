"""Forecasts held against flights: a picture and a Markdown page."""

from pathlib import Path

import pandas as pd

from pitotbench.show.markup import markdown_table
from pitotbench.show.style import BLUE, GREEN, GREY, ORANGE, canvas

_COLORS = (BLUE, ORANGE, GREEN)
_WITHIN = (0.9, 1.1)
_TICKS = (0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5)  # kt
_COLUMNS = {
    "maneuver": ("maneuver", ""),
    "turbulence": ("turbulence", ""),
    "das": ("DAS [Hz]", ""),
    "flights": ("flights", "d"),
    "minutes": ("time [min]", ".1f"),
    "predicted_kt": ("predicted 2σ [kt]", ".3f"),
    "flown_kt": ("flown 2σ [kt]", ".3f"),
    "flown_se_kt": ("± [kt]", ".3f"),
    "ratio": ("predicted / flown [-]", ".2f"),
    "per_step_decrease": ("flown, of Step Decrease's in equal minutes [-]", ".2f"),
    "error_kt": ("true rms error [kt]", ".3f"),
    "coverage": ("curve inside 2σ [%]", ".0%"),
}
_PAGE = """# What to fly: forecasts against flights

{provenance}

`pitotbench plan` says, before a flight, how well the curve will be known. Here every maneuver was then flown in
JSBSim's turbulence and calibrated, with the noise unknown to the calibrator. 2σ is the mean over 100 to 160 KIAS;
± is the standard error of the flown mean. *Flown, of Step Decrease's in equal minutes* is the ratio of the flown 2σ
to that of Step Decrease with the same data system, both brought to equal minutes by the square root of time.

{verdict}

![Predicted and flown 2σ](plan.png)

{table}

## How a forecast is made

1. The card is flown once in smooth air, in the expected wind.
2. Dryden gusts (MIL-F-8785C) of the expected level are drawn along its path, 16 times by default. They stand on the
   ground as the simulator's do, with the same axes; the ground velocity stays, the air data see them.
3. The data system records each draw, and the calibrator, which has to find the level and the length of the gusts
   itself, gives its bound. The mean over the draws is the forecast, their standard deviation what a single flight's
   bound may differ by.

For the search of a better card, which takes a flight a try, the inverse information matrix of the flight in smooth
air serves, for gusts of known level; `--json` shows both.

## Why turns

The bound is what gusts leave, and a gust lives for seconds: of a first-order gust of variance σ² and time constant
T the mean over a long time t has the variance 2Tσ²/t on a steady heading, but 2Tσ²/t/(1 + ω²T²) on the path of an
airplane that turns at ω, for the gust's direction turns away under it. At 45° of bank ωT is 0.6 at 160 KCAS and 1.6
at 100. And every speed meets every heading, so the wind is known far better than the curve. Two cautions: the
simulator's pressure error does not depend on the load factor, a real one may (the legs of the cloverleaf and the
two sides of the figure eight show a part of it); and headings are left out of the search, because the simulator's
turbulence has an axis on the ground, which real air does not have.
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
            xscale="log", yscale="log", xlabel="predicted 2σ [kt]", ylabel="flown 2σ, ± 2 standard errors [kt]"
        )
        for axis in (size.xaxis, size.yaxis):
            axis.set_ticks(_TICKS, [f"{tick:g}" for tick in _TICKS])
            axis.set_ticks([], minor=True)
        size.set(xlim=ends, ylim=ends)
        size.legend()
        ratio.axvspan(*_WITHIN, color="#E3F1E9")
        ratio.set(xlabel="predicted / flown 2σ [-]")
        ratio.invert_yaxis()
        figure.savefig(path, dpi=110)


def check_page(table: pd.DataFrame, provenance: str) -> str:
    """The Markdown page of a table with `add_reference`."""
    rows = ([_cell(row[key], style) for key, (_, style) in _COLUMNS.items()] for _, row in table.iterrows())
    lines = markdown_table([name for name, _ in _COLUMNS.values()], rows)
    return _PAGE.format(provenance=provenance, verdict=_verdict(table), table=lines)


def _cell(value: object, style: str) -> str:
    return format(value, style).replace("%", "") if style else str(value)


def _verdict(table: pd.DataFrame) -> str:
    low, high = _WITHIN
    inside = int(table.ratio.between(low, high).sum())
    best = table.sort_values("per_step_decrease").iloc[0]
    return (
        f"Predicted over flown 2σ: {table.ratio.min():.2f} to {table.ratio.max():.2f}, "
        f"mean {table.ratio.mean():.2f}; {inside} of {len(table)} cells within {low} to {high}.\n"
        f"The best for its minutes: {best.maneuver} at {best.das} Hz, turbulence {best.turbulence}, "
        f"with {best.per_step_decrease:.2f} of Step Decrease's 2σ."
    )
