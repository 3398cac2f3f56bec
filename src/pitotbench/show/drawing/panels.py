"""A panel of a page from a function that fills a chart."""

from collections.abc import Callable

from pitotbench.show.drawing.chart import Chart
from pitotbench.show.drawing.frame import drawing_of
from pitotbench.show.palette import WIDE, Panel

_POINTS = 72.0  # an inch


def chart_panel(
    title: str,
    draw: Callable[[Chart], None],
    note: str = "",
    size: tuple[float, float] = WIDE,
    legend_columns: int = 3,
) -> Panel:
    """A panel of a size [in] with the chart that `draw` fills; labeled marks go to a legend above the data."""
    chart = Chart()
    draw(chart)
    width, height = (_POINTS * side for side in size)
    return Panel(title, drawing_of(chart, title, width, height, legend_columns), note)
