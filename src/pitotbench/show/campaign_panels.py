"""The pictures of a campaign: which maneuver and how long, and the curves of its maneuvers."""

from collections.abc import Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from pitotbench.show.calibration import ShortAnswer
from pitotbench.show.campaign import MOST_CONDITIONS, condition_of, means_of, varied_columns
from pitotbench.show.columns import frame_rows
from pitotbench.show.curves import AIRSPEED, CORRECTION, MANEUVER_COLORS
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import (
    BLUE,
    GRAY,
    GREEN,
    INK,
    NARROW,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    Panel,
    band,
    dots,
    drawing,
    frame,
    line,
    panel,
)
from pitotbench.show.words import words

if TYPE_CHECKING:
    import pandas as pd

_SYSTEM_COLORS = (BLUE, ORANGE, GREEN, PURPLE, RED, SKY, GRAY)
_TITLE = "How well the curve is known, and after how long"
_LARGE = (4.8, 3.3)  # in: it shrinks to a phone
_APART = 0.014  # in ln of the minutes, between data systems of one maneuver
_NAME_WIDTH = 0.42  # of a name and its minutes, as a share of the axis
_LINE = 0.055  # height of a line of names, as a share of the axis
_TICKS = (1, 2, 3, 4, 5, 6, 8, 10, 15, 20, 30, 45, 60, 90, 120)  # min


def minutes_panels(
    results: "pd.DataFrame", drawn: Sequence[str] = (), units: Units = BENCH
) -> list[Panel]:
    """Return each maneuver's bound and true error over its minutes, a picture a condition flown.

    The pictures are those of the first model.
    """
    table = means_of(results, drawn)
    varied = varied_columns(table)
    chosen = [name for name in ("model", "calibration") if name in table]
    first = table[(table[chosen] == table[chosen].iloc[0]).all(axis=1)]
    rows: dict[str, list[dict[str, Any]]] = {}
    for row in frame_rows(first):
        rows.setdefault(condition_of(row, varied), []).append(row)
    model = f" ({first['model'].iloc[0]})" * (len({*table["model"]}) > 1)
    note = (
        "A dot: the mean ±2σ of the curve. A bar: twice its true rms error, which lies below the "
        "dot where the bound holds."
    )
    return [
        panel(
            ": ".join(filter(None, (f"{_TITLE}{model}", condition))),
            lambda axes, each=each: _draw_minutes(axes, each),  # type: ignore[misc]
            note,
            size=_LARGE,
            units=units,
        )
        for condition, each in islice(rows.items(), MOST_CONDITIONS)
    ]


def _draw_minutes(axes: Axes, rows: Sequence[dict[str, Any]]) -> None:
    systems = list(dict.fromkeys(row["das"] for row in rows))
    for number, system in enumerate(systems):
        here = [row for row in rows if row["das"] == system]
        shift = np.exp(_APART * (number - 0.5 * (len(systems) - 1)))
        minutes = shift * np.array([row["minutes"] for row in here])
        bound = np.array([row["two_sigma_kt"] for row in here])
        error = 2.0 * np.array([row["curve_rms_error_kt"] for row in here])
        color = _SYSTEM_COLORS[number % len(_SYSTEM_COLORS)]
        axes.vlines(minutes, bound, error, color=color, lw=0.8, alpha=0.6)
        dots(minutes, bound, color=color, marker="o", ms=5.0, label=f"±2σ, {system} Hz")(axes)
        dots(minutes, error, color=color, marker="_", ms=9.0, mew=1.8)(axes)
    dots([], [], color=INK, marker="_", ms=9.0, mew=1.8, label="2 × true rms error")(axes)
    frame("time recorded [min]", "mean ±2σ and 2 × true error [kt]", xscale="log")(axes)
    every = [row["minutes"] for row in rows]
    tops = [max(row["two_sigma_kt"], 2.0 * row["curve_rms_error_kt"]) for row in rows]
    axes.set(xlim=(0.75 * min(every), 1.35 * max(every)), ylim=(0.0, 1.4 * max(tops)))
    axes.set_xticks([t for t in _TICKS if 0.75 * min(every) <= t <= 1.35 * max(every)])
    axes.set_xticks([], minor=True)
    axes.xaxis.set_major_formatter("{x:g}")
    _name_maneuvers(axes, rows)


def _name_maneuvers(axes: Axes, rows: Sequence[dict[str, Any]]) -> None:
    """Write each maneuver with its minutes above its marks, and above a name that is in the way."""
    low, high = np.log(axes.get_xlim())
    height = _LINE * axes.get_ylim()[1]
    places: dict[str, tuple[float, float]] = {}  # by maneuver: ln of the minutes, and its top
    for row in rows:
        at, top = places.get(row["maneuver"], (0.0, 0.0))
        top = max(top, row["two_sigma_kt"], 2.0 * row["curve_rms_error_kt"])
        places[row["maneuver"]] = (at or float(np.log(row["minutes"])), top)
    written: list[tuple[float, float]] = []
    for name, (at, top) in sorted(places.items(), key=lambda item: item[1]):
        near = [t for a, t in places.values() if abs(a - at) < 0.5 * _NAME_WIDTH * (high - low)]
        levels = [y for a, y in written if abs(a - at) < _NAME_WIDTH * (high - low)]
        y = max([*near, *(level + height for level in levels)]) + 0.5 * height * (not levels)
        written.append((at, y))
        axes.vlines(np.exp(at), top, y, color=GRAY, lw=0.5, ls=":")
        axes.annotate(
            f"{words(name)}, {np.exp(at):.1f} min",
            (float(np.exp(at)), y),
            ha="center",
            va="bottom",
            fontsize=8.5,
        )


def maneuver_curve_panels(answers: Sequence[ShortAnswer], units: Units = BENCH) -> list[Panel]:
    """Return the correction that each maneuver found, with bound and truth, for each data system.

    A picture has the first flight of each maneuver.
    """
    flown = [answer for answer in answers if answer.curve]
    systems = list(dict.fromkeys(_system(answer) for answer in flown))
    maneuvers = list(dict.fromkeys(_maneuver(answer) for answer in flown))
    panels = []
    for system in systems:
        here = {_maneuver(a): a for a in reversed(flown) if _system(a) == system}
        marks = []
        for number, name in enumerate(n for n in maneuvers if n in here):
            curve = here[name].curve
            speed, value, bound = (
                np.array([getattr(point, key) for point in curve])
                for key in ("indicated_kt", "correction_kt", "two_sigma_kt")
            )
            color = MANEUVER_COLORS[number % len(MANEUVER_COLORS)]
            marks += [
                band(speed, value - bound, value + bound, color=color),
                line(speed, value, color=color, label=words(name)),
            ]
            if None not in (true := [point.true_kt for point in curve]):
                marks.append(line(speed, true, color=INK, ls="--", lw=1.0, label="truth"))
        draw = drawing(*marks, frame(AIRSPEED, CORRECTION))
        title = f"The correction that each maneuver finds, {system} Hz"
        panels.append(panel(title, draw, size=NARROW, units=units))
    return panels


def _maneuver(answer: ShortAnswer) -> str:
    return answer.subject.rpartition(" ")[0].partition("-seed")[0]


def _system(answer: ShortAnswer) -> str:
    return answer.subject.rpartition(" ")[2]
