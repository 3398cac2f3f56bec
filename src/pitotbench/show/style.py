"""How every picture looks, and how it becomes inline SVG: one stylesheet, colors for all kinds of color vision."""

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pitotbench.units import Array

mpl.use("Agg")

# Okabe and Ito (2008): eight colors for all kinds of color vision.
BLUE, ORANGE, GREEN, RED, SKY, PURPLE = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9", "#CC79A7"
INK, GREY, PALE = "#222222", "#777777", "#DDDDDD"
_MOST_POINTS = 1500

_SHEET = {
    "figure.facecolor": "white",
    "axes.edgecolor": "#999999",
    "axes.labelcolor": INK,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E8E8E8",
    "grid.linewidth": 0.7,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "font.family": "sans-serif",
    "svg.fonttype": "none",
    "svg.hashsalt": "pitotbench",
    "path.simplify_threshold": 0.5,
}


@contextmanager
def canvas(rows: int, columns: int, width: float, height: float) -> Iterator[tuple[Figure, list[Axes]]]:
    """A styled figure [in] with its axes in reading order, closed at the end."""
    with mpl.rc_context(_SHEET):  # type: ignore[arg-type]
        figure, axes = plt.subplots(rows, columns, figsize=(width, height), squeeze=False, layout="constrained")
        try:
            yield figure, list(axes.ravel())
        finally:
            plt.close(figure)


def svg(figure: Figure) -> str:
    """The figure as an SVG element without a fixed size, so that a page can scale it."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    head, rest = text.split(">", 1)
    return re.sub(r' (width|height)="[^"]*pt"', "", head) + ">" + rest


def thin(*arrays: Array) -> list[Array]:
    """Every n-th sample, so that a line has at most some 1,500 points."""
    step = max(1, len(arrays[0]) // _MOST_POINTS)
    return [array[::step] for array in arrays]


def broken(time: Array, *values: Array) -> list[Array]:
    """Time and values with a NaN wherever recording paused, so that no line is drawn across."""
    gaps = np.flatnonzero(np.diff(time) > 5.0 * np.median(np.diff(time))) + 1
    return [np.insert(np.asarray(array, dtype=np.float64), gaps, np.nan) for array in (time, *values)]
