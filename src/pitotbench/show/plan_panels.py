"""Pictures of a plan: the bound against minutes and against airspeed, and the ground tracks."""

from collections.abc import Sequence
from math import log

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.forecast import Forecast, Plan
from pitotbench.show.style import BLUE, GREEN, GREY, INK, ORANGE, PALE, PURPLE, RED, SKY, Panel, panel
from pitotbench.units import KNOT, NAUTICAL_MILE

_BELOW_DOTS = 3.0  # drawing order of names, above lines: the background of a name hides no other card's dot
_COLORS = (BLUE, ORANGE, GREEN, RED, PURPLE, SKY)
_CURVES = 6  # best maneuvers drawn: one color each
_TRACKS = 3
_LINE = 0.043  # height of a line of names, as a share of the axis
_NAME_WIDTH, _CLOSE = 0.4, 0.2  # natural logarithms: the width of a name in minutes, the height of close dots
_LARGE, _SQUARE = (7.4, 4.0), (3.8, 3.6)


def plan_panels(plan: Plan) -> list[Panel]:
    """The three pictures of a plan."""
    return [
        panel(
            "How well the curve is known, against minutes",
            lambda axes: draw_front(axes, plan),
            "A dot is a card flown once, with its 1σ between flights. The line from a dot is the same card flown "
            "repeatedly. Black: the Pareto front, the smallest bound that whole cards reach in so many minutes.",
            size=_LARGE,
        ),
        panel(
            "±2σ of the curve, by airspeed",
            lambda axes: draw_curves(axes, plan.forecasts[:_CURVES]),
            f"The {min(_CURVES, len(plan.forecasts))} best maneuvers, each flown once.",
        ),
        panel(
            "Ground covered",
            lambda axes: draw_tracks(axes, plan),
            "The best maneuvers in the expected wind. Recorded parts only: the set-ups need more ground.",
            size=_SQUARE,
        ),
    ]


def front(forecasts: Sequence[Forecast], last: float) -> list[tuple[float, float]]:
    """Minutes and ±2σ [m/s] of the Pareto front, up to `last` minutes, for cards flown once or more.

    No other choice takes fewer minutes and has a smaller bound.
    """
    choices = [
        (times * each.minutes, each.mean / times**0.5)
        for each in forecasts
        for times in range(1, int(last / each.minutes) + 1)
    ]
    best: list[tuple[float, float]] = []
    for minutes, bound in sorted(choices):
        if not best or bound < best[-1][1]:
            best.append((minutes, bound))
    return best


def draw_front(axes: Axes, plan: Plan) -> None:
    """Draw ±2σ [kt] against minutes, both logarithmic: a line of slope −½ is a card flown repeatedly."""
    shown = [*plan.forecasts, *([plan.improved] if plan.improved else [])]
    last = 1.6 * max(each.minutes for each in shown)
    for each in shown:
        minutes = np.geomspace(each.minutes, last, 20)
        color, marker, size = _look(plan, each)
        axes.plot(minutes, [each.mean_in(m) / KNOT for m in minutes], color=color, lw=0.6, alpha=0.5)
        axes.errorbar(
            each.minutes, each.mean / KNOT, each.spread / KNOT,
            fmt=marker, ms=size, color=color, elinewidth=0.8, zorder=_BELOW_DOTS + 1.0,
        )  # fmt: skip
    edge = front(shown, last)
    corners = [*(minutes for minutes, _ in edge), last], [*(bound / KNOT for _, bound in edge), edge[-1][1] / KNOT]
    axes.step(*corners, where="post", color=INK, lw=1.2, label="Pareto front")
    if plan.want is not None:
        axes.axhline(plan.want / KNOT, color=GREEN, ls="--", label=f"wanted, {plan.want / KNOT:g} kt")
    if plan.minutes is not None:
        axes.axvline(plan.minutes, color=ORANGE, ls="--", label=f"{plan.minutes:g} min")
    axes.set(xscale="log", yscale="log", xlabel="time recorded [min]", ylabel="mean ±2σ of the curve [kt]")
    axes.set_xlim(0.62 * min(each.minutes for each in shown), last)
    _name_dots(axes, plan, shown)
    _plain_ticks(axes)


def _look(plan: Plan, each: Forecast) -> tuple[str, str, float]:
    """Color, marker and size of a card's dot."""
    if each is plan.improved:
        return RED, "*", 10.0
    return (BLUE, "o", 6.0) if each is plan.best else (GREY, "o", 5.0)


def _name_dots(axes: Axes, plan: Plan, shown: Sequence[Forecast]) -> None:
    """Write the names next to the dots; to the right where another dot is close on the left, and pushed apart."""
    low, high = axes.get_ylim()
    line = (low / high) ** _LINE  # the axis is logarithmic: a line down is a ratio
    lowest: list[tuple[bool, float, float]] = []  # side, minutes and height of the names written so far
    for each in sorted(shown, key=lambda f: -f.mean):
        right = any(_is_close_on_the_left(other, each) for other in shown)
        near = [h for side, m, h in lowest if side == right and abs(log(m / each.minutes)) < _NAME_WIDTH]
        height = min([each.mean / KNOT, *(line * h for h in near)])
        lowest.append((right, each.minutes, height))
        axes.annotate(
            each.maneuver.replace("_", " ") + (", improved" if each is plan.improved else ""),
            (each.minutes, each.mean / KNOT),
            xytext=((1.03 if right else 0.97) * each.minutes, height),
            ha="left" if right else "right",
            va="center",
            fontsize=8,
            bbox={"facecolor": "white", "alpha": 0.9, "linewidth": 0.0, "pad": 0.5},
            color=_look(plan, each)[0] if each in (plan.best, plan.improved) else INK,
            zorder=_BELOW_DOTS,
        )


def _is_close_on_the_left(other: Forecast, each: Forecast) -> bool:
    """Whether another dot lies close to the left."""
    right, above = log(each.minutes / other.minutes), log(each.mean / other.mean)
    return 0.0 < right < _NAME_WIDTH and abs(above) < _CLOSE


def _plain_ticks(axes: Axes) -> None:
    """Put plain numbers on logarithmic axes."""
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        ticks = [m * 10.0**d for d in range(-4, 4) for m in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)]
        inside = [t for t in ticks if low <= t <= high]
        axis.set_ticks(inside, [f"{t:g}" for t in inside])
        axis.set_ticks([], minor=True)


def draw_curves(axes: Axes, forecasts: Sequence[Forecast]) -> None:
    """Draw ±2σ [kt] against indicated airspeed [kt]."""
    for number, each in enumerate(forecasts):
        axes.plot(
            each.airspeeds / KNOT,
            each.two_sigma / KNOT,
            color=_COLORS[number % len(_COLORS)],
            label=each.maneuver.replace("_", " "),
        )
    axes.set(xlabel="indicated airspeed [kt]", ylabel="±2σ of the curve [kt]")
    axes.set_ylim(bottom=0.0)


def draw_tracks(axes: Axes, plan: Plan) -> None:
    """Draw the ground tracks [nmi], each moved to the corner of the axes, and the box where one was given."""
    for number, each in enumerate(plan.forecasts[:_TRACKS]):
        north, east = each.track / NAUTICAL_MILE
        label = each.maneuver.replace("_", " ")
        axes.plot(east - np.nanmin(east), north - np.nanmin(north), color=_COLORS[number], lw=1.0, label=label)
    if plan.box is not None:
        side = plan.box / NAUTICAL_MILE
        axes.plot([0.0, side, side, 0.0, 0.0], [0.0, 0.0, side, side, 0.0], color=PALE, lw=2.0, label="box")
    axes.set(xlabel="east [nmi]", ylabel="north [nmi]")
    axes.set_aspect("equal", adjustable="datalim")
