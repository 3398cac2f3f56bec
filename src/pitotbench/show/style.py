"""The stylesheet of the pictures that matplotlib draws, and the conversion of axes to inline SVG."""

import io
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from hashlib import sha256

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pitotbench.show.palette import GRID, INK, SPINE, TICK, WIDE, Panel

_SHEET = {
    "figure.facecolor": "white",
    "axes.edgecolor": SPINE,
    "axes.labelcolor": INK,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "xtick.color": TICK,
    "ytick.color": TICK,
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


def panel(
    title: str,
    draw: Callable[[Axes], None],
    note: str = "",
    size: tuple[float, float] = WIDE,
    legend_columns: int = 3,
) -> Panel:
    """A panel of a size [in] with the axes that `draw` fills; labeled artists go to a legend above the data."""
    with drawn(draw, size, legend_columns) as figure:
        return Panel(title, svg(figure, title), note)


@contextmanager
def drawn(draw: Callable[[Axes], None], size: tuple[float, float], legend_columns: int) -> Iterator[Figure]:
    """The figure of a panel, to be saved inside the `with`."""
    with canvas(1, 1, *size) as (figure, (axes,)):
        draw(axes)
        handles, labels = axes.get_legend_handles_labels()
        if handles:
            figure.legend(handles, labels, loc="outside upper left", ncols=legend_columns, borderaxespad=0.1)
        yield figure


@contextmanager
def canvas(rows: int, columns: int, width: float, height: float) -> Iterator[tuple[Figure, list[Axes]]]:
    """A styled figure [in] with its axes in reading order; drawing and saving happen inside the `with`."""
    with mpl.rc_context(_SHEET):  # type: ignore[arg-type]
        figure = Figure(figsize=(width, height), layout="constrained")
        yield figure, list(figure.subplots(rows, columns, squeeze=False).ravel())


def svg(figure: Figure, label: str) -> str:
    """The figure as an SVG element without a fixed size, so that a page can scale it; `label` is read aloud."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r'<g id="[^"]*"', "<g", text)
    head, rest = text.split(">", 1)
    head = re.sub(r' (width|height)="[^"]*pt"', "", head) + f' role="img" aria-label="{label}"'
    return head + ">" + _unique_names(rest)


def _unique_names(text: str) -> str:
    """The drawing with names of clips and markers that no other drawing of a page has."""
    mark = sha256(text.encode()).hexdigest()[:8]
    return re.sub(r'(\bid="|url\(#|href="#)([^")]+)', rf"\1\2-{mark}", text)
