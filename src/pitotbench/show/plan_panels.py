"""The pictures of a plan: the bound against minutes and against airspeed, and the ground tracks."""

from collections.abc import Sequence
from math import log

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.forecast import Forecast, Plan
from pitotbench.show.plan import card_name
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PALE,
    PURPLE,
    RED,
    SKY,
    Panel,
    bars,
    drawing,
    frame,
    ground,
    level,
    line,
    panel,
)
from pitotbench.show.words import words
from pitotbench.units import KNOT, NAUTICAL_MILE

# drawing order of names, above lines: the background of a name hides no other card's dot
_BELOW_DOTS = 3.0
_COLORS = (BLUE, ORANGE, GREEN, RED, PURPLE, SKY)  # of the best maneuvers, which are drawn
_TRACKS = 3
_BOX = np.array([[0, 1, 1, 0, 0], [0, 0, 1, 1, 0]])  # corners of a square, in its sides
_LINE = 0.043  # height of a line of names, as a share of the axis
_NAME_WIDTH = 0.4  # of a name, in ln of the minutes
_CLOSE = 0.2  # ln of the bounds, by which dots that are close differ at most
_LARGE = (7.4, 4.0)  # in, width and height
_SQUARE = (3.8, 3.6)  # in


def bounds_panels(plan: Plan, units: Units = BENCH) -> list[Panel]:
    """The picture of a plan: the bound over the minutes."""
    return [
        panel(
            "How well the curve is known, against minutes",
            lambda axes: draw_bounds(axes, plan),
            "A dot is a card flown once, with its 1σ between flights. The line from a dot is the "
            "same card flown repeatedly: four times the minutes halve the bound. Both scales are "
            "logarithmic, so that these lines are straight.",
            size=_LARGE,
            units=units,
        )
    ]


def plan_panels(plan: Plan, units: Units = BENCH) -> list[Panel]:
    """What stands below the bound over the minutes: the bound by airspeed, and the ground."""
    best = zip(plan.forecasts, _COLORS, strict=False)
    named = [(each, color, words(each.maneuver)) for each, color in best]
    curves = drawing(
        *(line(f.airspeeds / KNOT, f.two_sigma / KNOT, color=c, label=n) for f, c, n in named),
        frame("indicated airspeed [kt]", "±2σ of the curve [kt]", ylim=(0.0, None)),
    )
    tracks = drawing(
        *(
            line(east - np.nanmin(east), north - np.nanmin(north), color=color, lw=1.0, label=name)
            for each, color, name in named[:_TRACKS]
            for north, east in [each.track / NAUTICAL_MILE]  # from the corner of the axes on
        ),
        *(
            line(side * _BOX[0], side * _BOX[1], color=PALE, lw=2.0, label="box")
            for side in ([] if plan.box is None else [plan.box / NAUTICAL_MILE])
        ),
        frame("east [nmi]", "north [nmi]"),
        ground,
    )
    flown = f"The {len(named)} best maneuvers, each flown once."
    covered = (
        "The best maneuvers in the expected wind. Recorded parts only: the set-ups need more "
        "ground."
    )
    return [
        panel("±2σ of the curve, by airspeed", curves, flown, units=units),
        panel("Ground covered", tracks, covered, size=_SQUARE),
    ]


def draw_bounds(axes: Axes, plan: Plan) -> None:
    """Draw ±2σ [kt] against minutes, both logarithmic: a line of slope −½ is a card flown
    repeatedly.
    """
    shown = [*plan.forecasts, *([plan.improved] if plan.improved else [])]
    last = max(1.6 * max(each.minutes for each in shown), 1.1 * (plan.minutes or 0.0))
    for each in shown:
        minutes = np.geomspace(each.minutes, last, 20)
        color, marker, size = _look(plan, each)
        bounds = [each.mean_in(m) / KNOT for m in minutes]
        line(minutes, bounds, color=color, lw=0.6, alpha=0.5)(axes)
        bars(
            each.minutes, each.mean / KNOT, each.spread / KNOT,
            fmt=marker, ms=size, color=color, elinewidth=0.8, zorder=_BELOW_DOTS + 1.0,
        )(axes)  # fmt: skip
    if plan.want is not None:
        wanted = plan.want / KNOT
        level(wanted, color=GREEN, ls="--", lw=1.4, label=f"wanted, {wanted:g} kt")(axes)
    if plan.minutes is not None:
        axes.axvline(plan.minutes, color=ORANGE, ls="--", label=f"{plan.minutes:g} min")
    frame(
        "time recorded, log scale [min]",
        "mean ±2σ of the curve, log scale [kt]",
        xscale="log",
        yscale="log",
        xlim=(0.62 * min(each.minutes for each in shown), last),
    )(axes)
    _name_dots(axes, plan, shown)
    for axis in (axes.xaxis, axes.yaxis):  # plain numbers on logarithmic axes
        low, high = axis.get_view_interval()
        ticks = [m * 10.0**d for d in range(-4, 4) for m in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)]
        inside = [t for t in ticks if low <= t <= high]
        axis.set_ticks(inside, [f"{t:g}" for t in inside])
        axis.set_ticks([], minor=True)


def _look(plan: Plan, each: Forecast) -> tuple[str, str, float]:
    """Color, marker and size of a card's dot."""
    if each is plan.improved:
        return RED, "*", 10.0
    return (BLUE, "o", 6.0) if each is plan.best else (GREY, "o", 5.0)


def _name_dots(axes: Axes, plan: Plan, shown: Sequence[Forecast]) -> None:
    """Write the names next to the dots; to the right where another dot is close on the left, and
    pushed apart.
    """
    low, high = axes.get_ylim()
    line = (low / high) ** _LINE  # the axis is logarithmic: a line down is a ratio
    lowest: list[
        tuple[bool, float, float]
    ] = []  # side, minutes and height of the names written so far
    for each in sorted(shown, key=lambda f: -f.mean):
        gaps = [
            (log(each.minutes / other.minutes), abs(log(each.mean / other.mean))) for other in shown
        ]
        right = any(0.0 < before < _NAME_WIDTH and above < _CLOSE for before, above in gaps)
        near = [
            h for side, m, h in lowest if side == right and abs(log(m / each.minutes)) < _NAME_WIDTH
        ]
        height = min([each.mean / KNOT, *(line * h for h in near)])
        lowest.append((right, each.minutes, height))
        axes.annotate(
            card_name(plan, each),
            (each.minutes, each.mean / KNOT),
            xytext=((1.03 if right else 0.97) * each.minutes, height),
            ha="left" if right else "right",
            va="center",
            fontsize=8,
            bbox={"facecolor": "white", "alpha": 0.9, "linewidth": 0.0, "pad": 0.5},
            color=_look(plan, each)[0] if each in (plan.best, plan.improved) else INK,
            zorder=_BELOW_DOTS,
        )
