"""The stylesheet of every picture, and the conversion of axes to inline SVG."""

import io
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import AutoLocator

from pitotbench.show.columns import with_minus_signs
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.timeline import pauses
from pitotbench.units import Array

# Okabe and Ito (2008): eight colors for all kinds of color vision.
BLUE, ORANGE, GREEN, RED, SKY, PURPLE = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#D55E00",
    "#56B4E9",
    "#CC79A7",
)
INK, GRAY, PALE = "#222222", "#777777", "#DDDDDD"
WIDE = (4.6, 2.9)  # in, width and height: two panels a row of a desktop page
NARROW = (3.6, 2.5)  # in: three panels a row
Mark = Callable[[Axes], object]  # a part of a picture: what draws it on axes
_MOST_POINTS = 1500  # of a line: more cannot be distinguished at the size of a panel

_SHEET = {
    "figure.facecolor": "white",
    "axes.edgecolor": "#999999",
    "axes.labelcolor": INK,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E8E8E8",
    "grid.linewidth": 0.7,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.4,
    "lines.linewidth": 1.4,
    "font.family": "sans-serif",
    "svg.fonttype": "none",
    "svg.hashsalt": "pitotbench",
    "path.simplify_threshold": 0.5,
}


@dataclass(frozen=True, slots=True)
class Panel:
    """One picture of a page: title and note are the page's text, the drawing an SVG element."""

    title: str
    drawing: str
    note: str = ""


def panel(
    title: str,
    draw: Mark | Sequence[Mark],
    note: str = "",
    size: tuple[float, float] = WIDE,
    legend_columns: int = 3,
    units: Units = BENCH,
) -> Panel:
    """Return a panel of a size [in] with the axes that `draw` fills, several below one another.

    The axes are filled in the units of the bench and read in those of the reader; labeled artists
    go to a legend above the data.
    """
    draws = draw if isinstance(draw, Sequence) else [draw]
    with stacked(draws, size, legend_columns, units) as figure:
        return Panel(title, svg(figure, title), note)


def drawing(*marks: Mark) -> Mark:
    """Some marks as one, each above those before it."""

    def draw(axes: Axes) -> None:
        for mark in marks:
            mark(axes)

    return draw


def line(x: Any, y: Any, *, color: str = BLUE, label: str = "", **look: Any) -> Mark:
    """Values over others, (n,) each, as a line."""
    return lambda axes: axes.plot(x, y, color=color, label=label, **look)


def dots(
    x: Any, y: Any, *, color: str = GRAY, label: str = "", marker: str = ".", **look: Any
) -> Mark:
    """Values over others, (n,) each, without a line."""
    return line(x, y, color=color, label=label, ls="none", marker=marker, **look)


def band(x: Array, low: Any, high: Any, *, color: str = BLUE, label: str = "") -> Mark:
    """What lies between two lines, each a number or (n,) as `x` is."""
    return lambda axes: axes.fill_between(x, low, high, color=color, alpha=0.25, lw=0, label=label)


def bars(x: Any, y: Any, half: Any, *, color: str, label: str = "", **look: Any) -> Mark:
    """Values with a bar from one side of each to the other."""
    return lambda axes: axes.errorbar(x, y, half, color=color, label=label, **look)


def level(y: float, *, color: str = INK, label: str = "", lw: float = 0.5, ls: str = "-") -> Mark:
    """A line across the picture; a dashed one is a value to compare with."""
    return lambda axes: axes.axhline(y, color=color, label=label, lw=lw, ls=ls)


def stripe(low: float, high: float, *, label: str) -> Mark:
    """What lies between two levels, in a pale color behind the lines."""
    return lambda axes: axes.axhspan(low, high, color=PALE, label=label)


def frame(x: str, y: str, **limits: Any) -> Mark:
    """The labels of the axes with their units in brackets, and their limits."""
    return lambda axes: axes.set(xlabel=x, ylabel=y, **limits)


def named_rows(names: Sequence[str]) -> Mark:
    """A row a name, the first on top: the names stand at the axis, where none touches another."""

    def draw(axes: Axes) -> None:
        axes.set_yticks(range(len(names)), names)
        axes.invert_yaxis()
        axes.grid(axis="y", visible=False)

    return draw


def written(x: float, row: int, text: str) -> Mark:
    """A text to the right of a place in a row."""
    look: dict[str, Any] = {"textcoords": "offset points", "va": "center", "fontsize": 8}
    return lambda axes: axes.annotate(text, (x, row), xytext=(5.0, 0.0), **look)


def ground(axes: Axes) -> None:
    """Let a mile north be as long as a mile east."""
    axes.set_aspect("equal", adjustable="datalim")


@contextmanager
def stacked(
    draws: Sequence[Mark],
    size: tuple[float, float],
    legend_columns: int,
    units: Units = BENCH,
) -> Iterator[Figure]:
    """Give the figure of axes one below the other, with one range of x and one legend.

    The legend has no repetitions.
    """
    with canvas(len(draws), 1, *size) as (figure, every):
        named: dict[str, Artist] = {}
        for draw, axes in zip(draws, every, strict=True):
            draw(axes)
            if axes is not every[0]:
                axes.set_xlim(every[0].get_xlim())
            for axis in (axes.xaxis, axes.yaxis):
                _translate(axis, units)
            handles, labels = axes.get_legend_handles_labels()
            named |= {
                units.text(label): handle
                for handle, label in zip(handles, labels, strict=True)
                if units.text(label) not in named
            }
        _add_legend(figure, named, legend_columns)
        yield figure


def _translate(axis: Axis, units: Units) -> None:
    """Write the label and the ticks of an axis in the reader's unit, by the label's `[unit]`."""
    label, _, unit = axis.get_label_text().removesuffix("]").rpartition("[")
    factor, symbol = units.scale(unit)
    if factor != 1.0:
        low, high = factor * np.sort(axis.get_view_interval())
        ticks = AutoLocator().tick_values(low, high)
        inside = ticks[(ticks >= low) & (ticks <= high)]
        axis.set_label_text(f"{label}[{symbol}]")
        axis.set_ticks(inside / factor, [with_minus_signs(f"{tick:g}") for tick in inside])


def _add_legend(figure: Figure, named: Mapping[str, Artist], most: int) -> None:
    """Add a legend above the axes, of as many columns as fit into the figure, at most `most`."""
    for columns in range(min(most, len(named)), 0, -1):
        legend = figure.legend(
            [*named.values()], [*named], loc="outside upper left", ncols=columns, borderaxespad=0.1
        )
        for name in legend.get_texts():
            name.set_parse_math(False)  # one from a file may hold dollars
        if columns == 1 or legend.get_window_extent().width <= figure.bbox.width:
            return
        legend.remove()


@contextmanager
def canvas(
    rows: int, columns: int, width: float, height: float
) -> Iterator[tuple[Figure, list[Axes]]]:
    """Give a styled figure [in] with its axes in reading order.

    Drawing and saving happen inside the `with`.
    """
    with mpl.rc_context(_SHEET):  # type: ignore[arg-type]
        figure = Figure(figsize=(width, height), layout="constrained")
        yield figure, list(figure.subplots(rows, columns, squeeze=False).ravel())


def svg(figure: Figure, label: str) -> str:
    """Return the figure as an SVG element without a fixed size, so that a page can scale it.

    `label` is read aloud.
    """
    layout = figure.get_layout_engine()
    if layout is not None:
        layout.execute(figure)
        figure.set_layout_engine(None)  # a figure with a layout engine is drawn twice
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r'<g id="[^"]*"', "<g", text)
    head, content = text.split(">", 1)
    head = re.sub(r' (width|height)="[^"]*pt"', "", head) + f' role="img" aria-label="{label}"'
    # No other drawing of a page has its names of clips and markers.
    mark = sha256(content.encode()).hexdigest()[:8]
    return head + ">" + re.sub(r'(\bid="|url\(#|href="#)([^")]+)', rf"\1\2-{mark}", content)


def thin(*arrays: Array) -> list[Array]:
    """Every n-th sample, so that a line has at most some 1,500 points."""
    step = max(1, -(-len(arrays[0]) // _MOST_POINTS))
    return [array[::step] for array in arrays]


def broken(time: Array, *values: Array) -> list[Array]:
    """Time and values with a NaN wherever recording paused, so that no line is drawn across."""
    after = pauses(time)
    return [
        np.insert(np.asarray(array, dtype=np.float64), after, np.nan) for array in (time, *values)
    ]
