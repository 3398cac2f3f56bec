"""Figures used again and again: their axes with all ticks take a third of the time of a picture to make."""

from collections.abc import Iterator
from contextlib import contextmanager

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

_kept: dict[int, Figure] = {}


@contextmanager
def reused_figure(rows: int, size: tuple[float, float]) -> Iterator[tuple[Figure, list[Axes]]]:
    """A figure of a size [in] with empty axes one below the other. After the `with` it holds no data.

    What a picture may change of its axes is artists, labels, scales, limits, margins, ticks, grid and aspect.
    """
    figure = _kept.pop(rows, None)
    if figure is None:
        figure = Figure()
        figure.subplots(rows, 1)
    figure.set_size_inches(size)
    yield figure, figure.axes
    # A figure is not kept where drawing failed.
    _empty(figure)
    _kept[rows] = figure


def _empty(figure: Figure) -> None:
    figure.set_layout_engine(None)
    for legend in figure.legends.copy():
        legend.remove()
    for axes in figure.axes:
        artists: list[Artist] = [*axes.lines, *axes.patches, *axes.collections, *axes.texts, *axes.images]
        for artist in artists:
            artist.remove()
        axes.containers.clear()
        axes.relim()
        axes.set(xscale="linear", yscale="linear", xlim=(0.0, 1.0), ylim=(0.0, 1.0), xlabel="", ylabel="")
        axes.set_aspect("auto", adjustable="box")
        axes.set_prop_cycle(None)
        axes.margins(0.05)
        axes.grid(visible=True)
        axes.autoscale()
        where = axes.get_subplotspec()
        assert where is not None
        axes.set_position(where.get_position(figure))
        axes.set_in_layout(True)
