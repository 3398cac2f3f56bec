"""What all pictures share: colors, sizes, the panel of a page, and lines thinned to what can be seen."""

from dataclasses import dataclass

import numpy as np

from pitotbench.timeline import pauses
from pitotbench.units import Array

# Okabe and Ito (2008): eight colors for all kinds of color vision.
BLUE, ORANGE, GREEN, RED, SKY, PURPLE = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9", "#CC79A7"
INK, GREY, PALE = "#222222", "#777777", "#DDDDDD"
SPINE, GRID, TICK = "#999999", "#E8E8E8", "#555555"
WIDE, NARROW = (4.6, 2.9), (3.6, 2.5)  # in: two and three panels a row of a desktop page
_MOST_POINTS = 1500  # of a line: more cannot be distinguished at the size of a panel


@dataclass(frozen=True, slots=True)
class Panel:
    """One picture of a page: its title and note are the page's text, the drawing is an SVG element."""

    title: str
    drawing: str
    note: str = ""


def thin(*arrays: Array) -> list[Array]:
    """Every n-th sample, so that a line has at most some 1,500 points."""
    step = max(1, -(-len(arrays[0]) // _MOST_POINTS))
    return [array[::step] for array in arrays]


def broken(time: Array, *values: Array) -> list[Array]:
    """Time and values with a NaN wherever recording paused, so that no line is drawn across."""
    after = pauses(time)
    return [np.insert(np.asarray(array, dtype=np.float64), after, np.nan) for array in (time, *values)]
