"""The study drawn: its charts and its page."""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter

from pitotbench.show.columns import frame_rows, html_table
from pitotbench.show.markup import environment
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
    WIDE,
    Panel,
    stacked,
    svg,
)
from pitotbench.units import Array
from pitotlab.study.parts import Bars, Chart, Lines, Part, Series, StudyPage
from pitotlab.tables import frame_columns

_COLORS = (BLUE, ORANGE, GREEN, PURPLE, RED, SKY, GREY)
_MARKS = "os^Dv<>"
_MOST_MARKED = 20  # points of a line that still get marks
_LEGEND = 2  # columns
_BARS = 0.82  # share of a group's place that bars fill


def draw(chart: Chart) -> Panel:
    """The chart as a panel of a page."""
    with stacked(_draws(chart), _size(chart), _LEGEND) as figure:
        return Panel(chart.title, svg(figure, chart.title), chart.note)


def _size(chart: Chart) -> tuple[float, float]:
    if isinstance(chart, Bars):
        return WIDE
    if chart.equal:
        return WIDE[1], WIDE[1]
    return (WIDE[0], 1.5 * WIDE[1]) if chart.below else WIDE


def _draws(chart: Chart) -> list[Callable[[Axes], None]]:
    """The functions that fill the axes of a chart, from top to bottom."""
    if isinstance(chart, Bars):
        return [partial(draw_dots if chart.dots else draw_bars, chart=chart)]
    return [partial(draw_lines, chart=each) for each in (chart, chart.below) if each]


def _placed(chart: Bars) -> Iterator[tuple[Series, Array, str, str]]:
    """Each series of a chart with its places on the axis, its color and its mark."""
    width, place = _BARS / len(chart.series), np.arange(float(len(chart.groups)))
    looks = zip(chart.series, cycle(_COLORS), cycle(_MARKS), strict=False)
    for number, (series, color, mark) in enumerate(looks):
        yield series, place + (number + 0.5) * width - 0.5 * _BARS, color, mark


def draw_bars(axes: Axes, chart: Bars) -> None:
    """Groups of bars; a whisker is ± one standard deviation over seeds."""
    for series, at, color, _ in _placed(chart):
        width = 0.92 * _BARS / len(chart.series)
        axes.bar(at, series.y, width, color=color, label=series.label)
        _whiskers(axes, at, series, ecolor=INK, elinewidth=0.9)
    _name_groups(axes, chart)


def draw_dots(axes: Axes, chart: Bars) -> None:
    """Groups of dots on an axis cut to the data; a whisker is ± one standard deviation over seeds."""
    for series, at, color, mark in _placed(chart):
        heights = np.asarray(series.y, dtype=np.float64)
        spreads = np.nan_to_num(np.asarray(series.spreads, dtype=np.float64))
        above = heights > (np.inf if chart.top is None else chart.top)
        top: Any = {"xycoords": ("data", "axes fraction"), "ha": "center", "size": 8}
        for x, y in zip(at[above], heights[above], strict=True):
            axes.annotate(f"{y:.2f} ↑", (x, 1.0), color=color, **top)
        look: Any = {"ms": 5.0, "capsize": 2.0, "elinewidth": 0.9, "label": series.label}
        axes.errorbar(at, heights, yerr=spreads, fmt=mark, color=color, **look)
    for edge in range(1, len(chart.groups)):
        axes.axvline(edge - 0.5, color=PALE, lw=0.8)
    axes.set_xlim(-0.5, len(chart.groups) - 0.5)
    axes.margins(y=0.08)
    if chart.top is not None:
        axes.set_ylim(top=chart.top)
    _name_groups(axes, chart)


def _name_groups(axes: Axes, chart: Bars) -> None:
    names = [name if "\n" in name else name.replace(" ", "\n", 1) for name in chart.groups]
    axes.set_xticks(np.arange(len(names), dtype=np.float64), names)
    axes.set_ylabel(chart.ylabel)
    axes.grid(axis="x", visible=False)


def draw_lines(axes: Axes, chart: Lines) -> None:
    """Every series on common axes."""
    for series, color, mark in zip(chart.series, cycle(_COLORS), cycle(_MARKS), strict=False):
        _draw_series(axes, series, color, mark)
    axes.set(xlabel="" if chart.below else chart.xlabel, ylabel=chart.ylabel)
    for axis, name, logarithmic in ((axes.xaxis, "x", chart.log_x), (axes.yaxis, "y", chart.log_y)):
        if logarithmic:
            axes.set(**{f"{name}scale": "log"})
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(NullFormatter())
    if chart.equal:
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.12)


# How a style is drawn; the color is that of the series unless given.
_STYLES: dict[str, dict[str, Any]] = {
    "steps": {"drawstyle": "steps-mid"},
    "marks": {"ls": "", "ms": 4.5},
    "dashed": {"ls": "--", "color": "black", "lw": 1.2},
    "limit": {"ls": ":", "color": GREY, "lw": 1.4},
    "band": {},
    "line": {"ms": 3.5},
}


def _draw_series(axes: Axes, series: Series, color: str, mark: str) -> None:
    x, y = np.asarray(series.x, dtype=np.float64), np.asarray(series.y, dtype=np.float64)
    if series.style == "dots":
        axes.plot(x, y, ".", color=GREY, ms=2.5, alpha=0.5, mew=0)
        axes.plot([], [], ".", color=GREY, label=series.label)  # a larger dot for the legend
        return
    marked = series.style == "marks" or (series.style == "line" and len(x) <= _MOST_MARKED)
    if series.style == "band":
        spread = np.asarray(series.spreads, dtype=np.float64)
        axes.fill_between(x, y - spread, y + spread, color=color, alpha=0.2, lw=0)
    look = {"color": color, "marker": mark if marked else None, **_STYLES[series.style]}
    axes.plot(x, y, label=series.label, **look)
    if series.style == "line":
        _whiskers(axes, x, series, ecolor=color, elinewidth=0.8)


def _whiskers(axes: Axes, x: Array, series: Series, **line: Any) -> None:
    if series.spreads is None:
        return
    heights, spread = (np.asarray(v, dtype=np.float64) for v in (series.y, series.spreads))
    known = np.isfinite(spread) & np.isfinite(heights)
    if known.any():
        axes.errorbar(x[known], heights[known], yerr=spread[known], fmt="none", capsize=2.0, **line)


def study_html(page: StudyPage) -> str:
    """One self-contained page."""
    groups = {
        "Claims": page.claims,
        "What the residual does not show": page.truth,
        "Open questions": page.questions,
    }
    shown = [(name, [_drawn(part) for part in parts]) for name, parts in groups.items() if parts]
    template = environment().from_string(Path(__file__).with_name("study.html").read_text("utf-8"))
    return template.render(page=page, groups=shown, summary=_html(page.summary))


def _drawn(part: Part) -> tuple[Part, list[Panel], list[str]]:
    return part, [draw(chart) for chart in part.charts], [_html(table) for table in part.tables]


def _html(table: pd.DataFrame) -> str:
    return html_table(frame_columns(table), frame_rows(table))
