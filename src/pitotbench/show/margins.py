"""Margins of a picture from its words and font sizes, so that it need not be drawn once to be laid out."""

from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

_POINTS = 72.0  # an inch
_LINE = 1.2  # height of a line of text over its font size
_EDGE, _GAP = 3.0, 6.0  # pt, free: at the edges of the figure; above axes
_FIRST_LEFT = 45.0  # pt: a usual margin, from which the ticks of axes with one scale follow


@dataclass(frozen=True, slots=True)
class _Frame:
    """The space for axes, one below the other [pt]: that of the figure, under its legend, and below each axes."""

    figure: tuple[float, float]
    top: float
    below: tuple[float, ...]
    aside: float

    def place(self, every: Sequence[Axes], left: float, right: float) -> None:
        width, height = self.figure
        room = height - self.top - sum(self.below) - _EDGE - _GAP * (len(every) - 1)
        wide, high = width - left - right - self.aside, room / len(every)
        upper = height - self.top
        for axes, below in zip(every, self.below, strict=True):
            axes.set_position((left / width, (upper - high) / height, wide / width, high / height))
            upper -= high + below + _GAP


def set_margins(figure: Figure, every: Sequence[Axes], legend_rows: int, aside: float) -> None:
    """Place axes one below the other, under a legend of some rows, with room for their ticks and labels.

    `aside` [in] stays free on the right. Texts that are drawn at data are not looked at.
    """
    width, height = (_POINTS * float(side) for side in figure.get_size_inches())
    top = _EDGE + _legend_height(legend_rows) + _GAP
    frame = _Frame((width, height), top, tuple(_below(axes) for axes in every), _POINTS * aside)
    # The ticks of x need no width and those of y no left margin, except where both axes have one scale.
    size = _points(mpl.rcParams["xtick.labelsize"])
    left, right = _FIRST_LEFT, _EDGE + 0.5 * max(_widest(axes.xaxis, size) for axes in every)
    frame.place(every, left, right)
    for axes in every:
        axes.apply_aspect()
    frame.place(every, _EDGE + max(_beside(axes) for axes in every), right)


def columns_that_fit(names: Sequence[str], width: float, most: int) -> int:
    """Return how many columns of a legend fit into a width [in]: from one to `most`."""
    rc, size = mpl.rcParams, _points(mpl.rcParams["legend.fontsize"])
    handle = size * (rc["legend.handlelength"] + rc["legend.handletextpad"])
    widths = np.array([handle + _text_width(name, size) for name in names])
    for columns in range(min(most, len(names)), 1, -1):
        # As the legend does: the first columns take one name more where the names do not divide evenly.
        needed = sum(float(column.max()) for column in np.array_split(widths, columns))
        needed += size * (rc["legend.columnspacing"] * (columns - 1) + 2.0 * rc["legend.borderpad"])
        if needed + 2.0 * _EDGE <= _POINTS * width:
            return columns
    return 1


def _legend_height(rows: int) -> float:
    rc, size = mpl.rcParams, _points(mpl.rcParams["legend.fontsize"])
    between = rc["legend.labelspacing"] * (rows - 1)
    return size * float(_LINE * rows + between + 2.0 * rc["legend.borderpad"]) if rows else 0.0


def _below(axes: Axes) -> float:
    """Return the height of the ticks, their words and the label below axes [pt]."""
    rc = mpl.rcParams
    lines = max((word.count("\n") + 1 for word in _words(axes.xaxis)), default=0)
    words = lines * _LINE * _points(rc["xtick.labelsize"])
    return float(rc["xtick.major.size"] + rc["xtick.major.pad"]) + words + _label(axes.xaxis)


def _beside(axes: Axes) -> float:
    """Return the width of the ticks, their words and the label left of axes [pt]."""
    rc = mpl.rcParams
    words = _widest(axes.yaxis, _points(rc["ytick.labelsize"]))
    return float(rc["ytick.major.size"] + rc["ytick.major.pad"]) + words + _label(axes.yaxis)


def _label(axis: Axis) -> float:
    text = axis.get_label_text()
    lines = text.count("\n") + 1
    return lines * _LINE * _points(mpl.rcParams["axes.labelsize"]) + float(axis.labelpad) if text else 0.0


def _widest(axis: Axis, size: float) -> float:
    return max((_text_width(line, size) for word in _words(axis) for line in word.split("\n")), default=0.0)


def _words(axis: Axis) -> list[str]:
    """Return the words at the ticks in sight."""
    low, high = sorted(axis.get_view_interval())
    ticks = [tick for tick in axis.get_majorticklocs() if low <= tick <= high]
    return axis.get_major_formatter().format_ticks(ticks)


def _points(size: float | str) -> float:
    """Return a font size, which may be a word such as `medium`, in points."""
    return FontProperties(size=size).get_size_in_points()


def _text_width(text: str, size: float) -> float:
    width, _, _ = text_to_path.get_text_width_height_descent(text, FontProperties(size=size), "$" in text)
    return float(width)
