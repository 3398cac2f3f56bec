"""Pictures of a plan: 2σ against minutes with the Pareto front, 2σ against airspeed, ground tracks."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.forecast import Forecast, Plan
from pitotbench.show.style import BLUE, GREEN, GREY, INK, ORANGE, PALE, PURPLE, RED, SKY, Panel, panel
from pitotbench.units import KNOT, NAUTICAL_MILE

_COLORS = (BLUE, ORANGE, GREEN, RED, PURPLE, SKY)
_CURVES = 6  # of the best maneuvers
_TRACKS = 3
_LARGE, _SQUARE = (7.4, 4.0), (3.8, 3.6)


def plan_panels(plan: Plan) -> list[Panel]:
    """The three pictures of a plan."""
    return [
        panel(
            "How well the curve is known, against minutes",
            lambda axes: draw_front(axes, plan),
            "A dot is a card flown once; its line, the same card flown again and again. Black: the Pareto "
            "front, the least 2σ that single cards reach in so many minutes.",
            size=_LARGE,
        ),
        panel(
            "2σ of the curve, by airspeed",
            lambda axes: draw_curves(axes, plan.forecasts[:_CURVES]),
            f"The {min(_CURVES, len(plan.forecasts))} best, each flown once.",
        ),
        panel(
            "Ground covered",
            lambda axes: draw_tracks(axes, plan),
            "Recorded parts, in the expected wind; set-ups come on top.",
            size=_SQUARE,
        ),
    ]


def front(forecasts: Sequence[Forecast]) -> list[Forecast]:
    """The forecasts that no other beats in both minutes and 2σ, in order of minutes."""
    best: list[Forecast] = []
    for each in sorted(forecasts, key=lambda f: (f.minutes, f.mean)):
        if not best or each.mean < best[-1].mean:
            best.append(each)
    return best


def draw_front(axes: Axes, plan: Plan) -> None:
    """2σ [kt] against minutes, both logarithmic: a line of slope −½ is a card flown again and again."""
    shown = [*plan.forecasts, *([plan.improved] if plan.improved else [])]
    last = 1.5 * max(each.minutes for each in shown)
    for each in shown:
        minutes = np.geomspace(each.minutes, last, 20)
        improved, chosen = each is plan.improved, each is plan.best
        color = RED if improved else BLUE if chosen else GREY
        axes.plot(minutes, [each.mean_in(m) / KNOT for m in minutes], color=color, lw=0.7, alpha=0.6)
        axes.errorbar(
            each.minutes,
            each.mean / KNOT,
            yerr=each.spread / KNOT,
            fmt="*" if improved else "o",
            ms=9 if improved else 5,
            color=color,
            elinewidth=0.8,
        )
        name = each.maneuver.replace("_", " ") + (", improved" if improved else "")
        place = (6, -11) if improved else (6, 4)
        axes.annotate(name, (each.minutes, each.mean / KNOT), xytext=place, textcoords="offset points", fontsize=8)
    edge = front(plan.forecasts)
    axes.step(
        [*(f.minutes for f in edge), last],
        [*(f.mean / KNOT for f in edge), edge[-1].mean / KNOT],
        where="post",
        color=INK,
        lw=1.2,
        label="Pareto front",
    )
    if plan.want is not None:
        axes.axhline(plan.want / KNOT, color=GREEN, ls="--", label=f"wanted, {plan.want / KNOT:g} kt")
    if plan.minutes is not None:
        axes.axvline(plan.minutes, color=ORANGE, ls="--", label=f"{plan.minutes:g} min")
    axes.set(xscale="log", yscale="log", xlabel="time recorded [min]", ylabel="mean 2σ of the curve [kt]")
    _plain_ticks(axes)


def _plain_ticks(axes: Axes) -> None:
    """Plain numbers on logarithmic axes, at 1, 2, 3 and 5 of a decade."""
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        ticks = [m * 10.0**d for d in range(-4, 4) for m in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)]
        inside = [t for t in ticks if low <= t <= high]
        axis.set_ticks(inside, [f"{t:g}" for t in inside])
        axis.set_ticks([], minor=True)


def draw_curves(axes: Axes, forecasts: Sequence[Forecast]) -> None:
    """2σ [kt] against indicated airspeed [kt]."""
    for number, each in enumerate(forecasts):
        axes.plot(
            each.airspeeds / KNOT,
            each.two_sigma / KNOT,
            color=_COLORS[number % len(_COLORS)],
            label=each.maneuver.replace("_", " "),
        )
    axes.set(xlabel="indicated airspeed [kt]", ylabel="2σ of the curve [kt]")
    axes.set_ylim(bottom=0.0)


def draw_tracks(axes: Axes, plan: Plan) -> None:
    """Ground tracks [nmi], each from its own corner, and the box where one was given."""
    for number, each in enumerate(plan.forecasts[:_TRACKS]):
        north, east = each.track / NAUTICAL_MILE
        label = each.maneuver.replace("_", " ")
        axes.plot(east - east.min(), north - north.min(), color=_COLORS[number], lw=1.0, label=label)
    if plan.box is not None:
        side = plan.box / NAUTICAL_MILE
        axes.plot([0.0, side, side, 0.0, 0.0], [0.0, 0.0, side, side, 0.0], color=PALE, lw=2.0, label="box")
    axes.set(xlabel="east [nmi]", ylabel="north [nmi]")
    axes.set_aspect("equal", adjustable="datalim")
