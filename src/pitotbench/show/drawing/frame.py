"""A chart as an SVG element: margins, grid, ticks, labels and legend around its marks.

The margins follow from the number of legend lines and the widest tick label. Numbers are points.
"""

from html import escape

import numpy as np

from pitotbench.show.drawing.chart import Chart, Mark
from pitotbench.show.drawing.letters import text_width
from pitotbench.show.drawing.shapes import KEY_WIDTH, Scale, stroke
from pitotbench.show.drawing.ticks import tick_words, ticks_between
from pitotbench.show.palette import GRID, INK, SPINE, TICK
from pitotbench.units import Array

_EDGE = 3.0  # free on every side
_LABEL, _TICK, _LEGEND = 9.0, 8.5, 8.0  # font sizes
_OUT = 3.5  # length of a tick
_LEFT, _BELOW, _BELOW_NAMES = 23.0, 31.5, 20.2  # beside tick labels; below with a label, and with names alone
_LINE = 10.2  # from line to line of a tick's name
_FIRST_ENTRY, _ENTRY, _KEY = 10.1, 12.0, 4.0  # legend: its first line, the distance of lines, its left end
_BEFORE_TEXT, _BETWEEN = 6.4, 11.2  # legend: after a key, between columns
_UNDER_LEGEND = 1.3
_FONT = "'DejaVu Sans','Bitstream Vera Sans',Verdana,Arial,Helvetica,sans-serif"


def drawing_of(chart: Chart, label: str, width: float, height: float, legend_columns: int) -> str:
    """Return a chart of a size [pt] as an SVG element without a fixed size, so that a page can scale it.

    `label` is read aloud. Labeled marks go to a legend above the data.
    """
    legend, rows = _legend(chart, legend_columns)
    top = _FIRST_ENTRY + _ENTRY * (rows - 1) + _UNDER_LEGEND + _ENTRY if rows else _EDGE
    lines = max((name.count("\n") + 1 for name in chart.names), default=1)
    below = _BELOW if chart.xlabel else _BELOW_NAMES + _LINE * (lines - 1)
    high = height - top - below
    # The width of the tick labels depends on the limits, and with equal axes these depend on the width.
    scale = _scale(chart, width - _LEFT - _EDGE, high)
    y_ticks = _y_ticks(scale)
    left = _LEFT + max(text_width(word, _TICK) for word in tick_words(y_ticks))
    scale = _scale(chart, width - left - _EDGE - _beside(chart, width - left), high)
    inside = "".join(mark.svg(scale) for mark in sorted(chart.marks, key=lambda mark: mark.layer))
    return (
        f'<svg viewBox="0 0 {width:g} {height:g}" xmlns="http://www.w3.org/2000/svg" version="1.1" role="img" '
        f'aria-label="{escape(label)}" font-family="{_FONT}" stroke-linejoin="round">'
        f'<rect width="{width:g}" height="{height:g}" fill="white"/>{legend}'
        f'<g transform="translate({left:.1f} {top:.1f})">'
        f"{_axes(chart, scale, left)}{_aside(chart, scale)}"
        f'<svg width="{scale.width:.1f}" height="{scale.height:.1f}">{inside}</svg>'
        f'<path d="M0 0V{scale.height:.1f}H{scale.width:.1f}" {stroke(SPINE, 0.8)}/></g></svg>'
    )


def _scale(chart: Chart, width: float, height: float) -> Scale:
    """The limits of the axes: with `equal`, the axis with units to spare shows more."""
    (left, right), (bottom, top) = chart.x.limits(), chart.y.limits()
    if chart.equal:
        unit = max((right - left) / width, (top - bottom) / height)
        for_x, for_y = 0.5 * (unit * width - (right - left)), 0.5 * (unit * height - (top - bottom))
        left, right, bottom, top = left - for_x, right + for_x, bottom - for_y, top + for_y
    return Scale(left, right, bottom, top, width, height)


def _x_ticks(scale: Scale) -> Array:
    return ticks_between(scale.left, scale.right, int(scale.width / (3.0 * _TICK)))


def _y_ticks(scale: Scale) -> Array:
    return ticks_between(scale.bottom, scale.top, int(scale.height / (2.0 * _TICK)))


def _axes(chart: Chart, scale: Scale, left: float) -> str:
    """Grid, ticks, their words and the labels of both axes."""
    across = np.arange(len(chart.names), dtype=np.float64) if chart.names else _x_ticks(scale)
    words = list(chart.names) or tick_words(across)
    down = _y_ticks(scale)
    xs, ys = scale.x(across), scale.y(down)
    wide, high = scale.width, scale.height
    grid = "".join(f"M{x:.1f} 0V{high:.1f}" for x in xs) if chart.vertical_grid else ""
    grid += "".join(f"M0 {y:.1f}H{wide:.1f}" for y in ys)
    marks = "".join(f"M{x:.1f} {high:.1f}v{_OUT}" for x in xs) + "".join(f"M0 {y:.1f}h{-_OUT}" for y in ys)
    below = "".join(_below(x, high, word) for x, word in zip(xs, words, strict=True))
    beside = "".join(
        f'<text x="-7" y="{y + 3.2:.1f}">{word}</text>' for y, word in zip(ys, tick_words(down), strict=True)
    )
    labels = _text(0.5 * wide, high + 26.3, chart.xlabel) if chart.xlabel else ""
    upward = f'transform="translate({9.8 - left:.1f} {0.5 * high:.1f}) rotate(-90)"'
    labels += f"<g {upward}>{_text(0.0, 0.0, chart.ylabel)}</g>"
    return (
        f'<path d="{grid}" {stroke(GRID, 0.7)}/><path d="{marks}" {stroke(TICK, 0.8)}/>'
        f'<g font-size="{_TICK}" fill="{TICK}">'
        f'<g text-anchor="middle">{below}</g><g text-anchor="end">{beside}</g></g>'
        f'<g font-size="{_LABEL}" fill="{INK}" text-anchor="middle">{labels}</g>'
    )


def _below(x: float, high: float, word: str) -> str:
    return "".join(_text(x, high + 13.5 + _LINE * i, line) for i, line in enumerate(word.split("\n")))


def _text(x: float, y: float, words: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}">{escape(words)}</text>'


def _legend(chart: Chart, columns: int) -> tuple[str, int]:
    """The legend as SVG, filled column by column, and the number of its lines."""
    entries = _entries(chart)
    if not entries:
        return "", 0
    drawn, x = [], _KEY
    parts = [list(part) for part in np.array_split(np.arange(len(entries)), min(columns, len(entries)))]
    for part in parts:
        for row, number in enumerate(part):
            y = _FIRST_ENTRY + _ENTRY * row
            key = f'<g transform="translate({x:.1f} {y - 2.8:.1f})">{entries[number].key}</g>'
            drawn.append(key + _text(x + KEY_WIDTH + _BEFORE_TEXT, y, entries[number].label))
        widest = max(text_width(entries[number].label, _LEGEND) for number in part)
        x += KEY_WIDTH + _BEFORE_TEXT + widest + _BETWEEN
    return f'<g font-size="{_LEGEND:g}">{"".join(drawn)}</g>', len(parts[0])


def _entries(chart: Chart) -> list[Mark]:
    """The labeled marks; measured points come last."""
    return sorted((mark for mark in chart.marks if mark.label), key=lambda mark: mark.layer > 2)


def _beside(chart: Chart, room: float) -> float:
    """The width that the aside takes of the room on the right of the axes' left edge."""
    if chart.aside is None:
        return 0.0
    half = 0.5 * max(text_width(line, _LEGEND) for line in chart.aside.lines)
    return room - _EDGE - (room - _EDGE - half) / chart.aside.x


def _aside(chart: Chart, scale: Scale) -> str:
    if chart.aside is None:
        return ""
    aside = chart.aside
    x, y = aside.x * scale.width, (1.0 - aside.y) * scale.height
    ahead, up = aside.toward[0] * scale.width, -aside.toward[1] * scale.height
    turn = np.degrees(np.arctan2(up, ahead))
    head = f'<path transform="translate({x + ahead:.1f} {y + up:.1f}) rotate({turn:.1f})" d="M0 0l-6 2.4v-4.8z"'
    lines = "".join(_text(x, y + 28.0 + 9.6 * i, line) for i, line in enumerate(aside.lines))
    return (
        f'<path d="M{x - ahead:.1f} {y - up:.1f}l{2.0 * ahead:.1f} {2.0 * up:.1f}" {stroke(aside.color, 1.6)}/>'
        f'{head} fill="{aside.color}" stroke="{aside.color}"/>'
        f'<g font-size="{_LEGEND:g}" fill="{aside.color}" text-anchor="middle">{lines}</g>'
    )
