"""The pictures of a plan: the bound and the minutes of each card, by airspeed, the ground."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.forecast import Forecast, Plan
from pitotbench.show.plan import card_name
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import (
    BLUE,
    GRAY,
    GREEN,
    ORANGE,
    PALE,
    PURPLE,
    RED,
    SKY,
    WIDE,
    Mark,
    Panel,
    dots,
    drawing,
    frame,
    ground,
    line,
    named_rows,
    panel,
    written,
)
from pitotbench.show.words import words
from pitotbench.units import KNOT, NAUTICAL_MILE

_COLORS = (BLUE, ORANGE, GREEN, RED, PURPLE, SKY)  # of the best maneuvers, which are drawn
_TRACKS = 3  # maneuvers whose ground track is drawn
_BOX = np.array([[0, 1, 1, 0, 0], [0, 0, 1, 1, 0]])  # corners of a square, in its sides
_ROW = 0.23  # in, height of a card's row
_SQUARE = (3.8, 3.6)  # in


def bounds_panels(plan: Plan, units: Units = BENCH) -> list[Panel]:
    """Return the pictures of a plan, a row a card: bound flown once, minutes to a wanted one.

    The second is drawn only where a bound is wanted.
    """
    rows = _rows(plan)
    size = (WIDE[0], 0.9 + _ROW * len(rows))
    title = "±2σ of the curve from one flight"
    note = "The bar is the 1σ between flights. Written beside it: the minutes recorded."
    if not all(_is_allowed(plan, each) for each in rows):
        note += " A hollow dot does not fit into the minutes or the box."
    found = [panel(title, lambda axes: draw_bounds(axes, plan), note, size, units=units)]
    if (want := plan.want) is not None:
        minutes = [each.times_for(want) * each.minutes for each in rows]
        flights = [f"{each.times_for(want)} flights" for each in rows]
        draw = drawing(
            *_named_dots(plan, rows, minutes, flights),
            frame("minutes recorded in all [min]", "", xlim=(0.0, 1.35 * max(minutes))),
        )
        wanted = f"Minutes until ±{want / KNOT:g} kt (2σ)"
        found.append(panel(units.text(wanted), draw, size=size, units=units))
    return found


def _rows(plan: Plan) -> list[Forecast]:
    return [*([plan.improved] if plan.improved else []), *plan.forecasts]


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
    """Draw ±2σ [kt] of each card flown once with its 1σ between flights, a row a card."""
    rows = _rows(plan)
    bounds = [each.mean / KNOT for each in rows]
    texts = [f"{each.minutes:.1f} min" for each in rows]
    drawing(
        *_named_dots(plan, rows, bounds, texts, [each.spread / KNOT for each in rows]),
        frame("mean ±2σ of the curve [kt]", "", xlim=(0.0, 1.4 * max(bounds))),
    )(axes)


def _is_allowed(plan: Plan, each: Forecast) -> bool:
    return each.fits(plan.box) and each.ends_in(plan.minutes)


def _named_dots(
    plan: Plan,
    rows: Sequence[Forecast],
    values: Sequence[float],
    texts: Sequence[str],
    spreads: Sequence[float] | None = None,
) -> list[Mark]:
    """Return a dot a card in a row with its name, and a text beside the dot.

    A dot is hollow where the card does not fit into the minutes or the box of the request.
    """
    marks: list[Mark] = []
    for row, each in enumerate(rows):
        color = BLUE if each in (plan.best, plan.improved) else GRAY
        fill = color if _is_allowed(plan, each) else "white"
        spread = 0.0 if spreads is None else spreads[row]
        ends = (values[row] - spread, values[row] + spread)
        marks += [
            line(ends, (row, row), color=color, lw=0.8),
            dots([values[row]], [row], color=color, marker="o", ms=5.0, mfc=fill),
            written(ends[1], row, texts[row]),
        ]
    return [*marks, named_rows([card_name(plan, each) for each in rows])]
