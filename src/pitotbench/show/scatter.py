"""A scatter of two columns of results, as an SVG file."""

import pandas as pd
from matplotlib.axes import Axes

from pitotbench.show.style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, stacked, svg

_COLORS = (BLUE, ORANGE, GREEN, RED, SKY, PURPLE, GREY)
_SIZE = (7.0, 4.4)  # in
_MOST_POINTS = 20_000  # more cannot be distinguished


def scatter_svg(results: pd.DataFrame, vertical: str, horizontal: str) -> str:
    """One column of results drawn against another, a color a maneuver, as the text of an SVG file."""
    step = max(1, -(-len(results) // _MOST_POINTS))

    def draw(axes: Axes) -> None:
        for number, (name, rows) in enumerate(results.iloc[::step].groupby("maneuver", sort=False)):
            color = _COLORS[number % len(_COLORS)]
            axes.plot(rows[horizontal], rows[vertical], ".", markersize=4, alpha=0.6, color=color, label=str(name))
        axes.set_xlabel(horizontal)
        axes.set_ylabel(vertical)

    with stacked([draw], _SIZE, legend_columns=4) as figure:
        text = svg(figure, f"{vertical} against {horizontal}")
    return text if "xmlns=" in text else text.replace("<svg", '<svg xmlns="http://www.w3.org/2000/svg"', 1)
