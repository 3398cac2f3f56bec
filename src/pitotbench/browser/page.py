"""The page as a document of Bokeh: three pictures, and the texts of the desk for the page's script."""

import json
from importlib import resources
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.events import SelectionGeometry
from bokeh.models import (
    BoxSelectTool,
    BoxZoomTool,
    ColumnDataSource,
    HoverTool,
    LinearAxis,
    NumeralTickFormatter,
    Range1d,
    Span,
    TapTool,
    Whisker,
)
from bokeh.plotting import figure
from jinja2 import Template

from pitotbench.browser.desk import Desk
from pitotbench.browser.words import state_of
from pitotbench.timeline import minutes_text
from pitotbench.units import FOOT, SUFFIXES, SYMBOLS

# Okabe and Ito (2008): colors for all kinds of color vision; the kinds of lines differ as well.
_BLUE = "#0072B2"
_ORANGE = "#B36200"  # darker than theirs, for thin lines and numbers on white
_GREEN = "#009E73"
_INK = "#222222"
_GREY = "#777777"
_TALL = 300  # px
_LOW = 260  # px
_FAINT = 0.15
_KILOMETER = 1000.0  # m
_MINUTE = 60.0  # s


def own_file(name: str) -> str:
    """Return a file of the page."""
    return (resources.files("pitotbench.browser") / "page" / name).read_text(encoding="utf-8")


class View:
    """The pictures of a desk in one tab."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._shown: tuple[object, ...] = ()
        self.rows = ColumnDataSource(_columns("minute", "speed", "height", "north", "east"))
        self.used = ColumnDataSource(_columns("begin", "end"))
        self.marked = ColumnDataSource(_columns("minute", "speed", "correction"))
        self.curve = ColumnDataSource(_columns("speed", "correction", "low", "high", "bound"))
        self.samples = ColumnDataSource(_columns("minute", "speed", "correction"))
        self.points = ColumnDataSource(_columns("speed", "correction", "low", "high", "method"))
        self.time = self._time_picture()
        self.track = self._track_picture()
        self.error = self._error_picture()
        self.samples.selected.on_change("indices", self._tapped)
        self.time.on_event(SelectionGeometry, self._brushed)

    def _time_picture(self) -> Any:
        brush = BoxSelectTool(dimensions="width", renderers=[], description="brush minutes")
        plot = _figure("time [min]", "indicated airspeed", _TALL, [brush, "xwheel_zoom"])
        plot.toolbar.active_drag = brush
        plot.vstrip("begin", "end", source=self.used, fill_color=_GREEN, fill_alpha=_FAINT,
                    line_alpha=0.0)  # fmt: skip
        heights = Range1d(0.0, 1.0)
        plot.extra_y_ranges = {"height": heights}
        line = plot.line("minute", "height", source=self.rows, color=_ORANGE, line_dash="dashed",
                         y_range_name="height")  # fmt: skip
        plot.add_layout(
            LinearAxis(
                y_range_name="height", axis_label="pressure altitude [ft]", axis_label_text_color=_ORANGE,
                formatter=NumeralTickFormatter(format="0,0"),
            ),
            "right",
        )  # fmt: skip
        self.heights = heights
        speed = plot.line("minute", "speed", source=self.rows, color=_BLUE)  # fmt: skip
        plot.scatter("minute", "speed", source=self.marked, size=12, marker="diamond",
                     fill_color=_ORANGE, line_color=_INK)  # fmt: skip
        plot.yaxis[0].axis_label_text_color = _BLUE
        plot.y_range.renderers = [speed]  # the height has its own
        self.time_hover = HoverTool(renderers=[speed], mode="vline")
        plot.add_tools(self.time_hover)
        line.nonselection_glyph = speed.nonselection_glyph = None
        return plot

    def _track_picture(self) -> Any:
        plot = _figure("east [km]", "north [km]", _LOW, ["wheel_zoom"], match_aspect=True)
        way = plot.line("east", "north", source=self.rows, color=_BLUE)
        plot.scatter("east", "north", source=self.rows, size=2, color=_BLUE, alpha=_FAINT)
        self.track_hover = HoverTool(renderers=[way])
        plot.add_tools(self.track_hover)
        return plot

    def _error_picture(self) -> Any:
        tap = TapTool()
        plot = _figure("indicated airspeed", "correction", _TALL, [tap, "wheel_zoom"])
        plot.varea("speed", "low", "high", source=self.curve, fill_color=_BLUE, fill_alpha=_FAINT)  # fmt: skip
        dots = plot.scatter("speed", "correction", source=self.samples, size=4, color=_GREY,
                            alpha=0.4)  # fmt: skip
        dots.nonselection_glyph = dots.glyph
        tap.renderers = [dots]
        line = plot.line("speed", "correction", source=self.curve, color=_BLUE, line_width=2)  # fmt: skip
        plot.add_layout(Whisker(base="speed", lower="low", upper="high", source=self.points))
        plot.scatter("speed", "correction", source=self.points, size=8, marker="square",
                     fill_color="white", line_color=_INK)  # fmt: skip
        plot.scatter("speed", "correction", source=self.marked, size=12, marker="diamond",
                     fill_color=_ORANGE, line_color=_INK)  # fmt: skip
        plot.add_layout(Span(location=0.0, dimension="width", line_color=_INK, line_width=0.5))
        self.error_hover = HoverTool(renderers=[line], mode="vline")
        plot.add_tools(self.error_hover)
        return plot

    def render(self) -> None:
        """Show the desk as it is now; what has not changed stays, with its zoom."""
        desk = self._desk
        text = json.dumps(state_of(desk), allow_nan=False)
        if self.time.tags != [text]:  # a property that nothing draws: the texts are no HTML
            self.time.tags = [text]
        shown = (desk.look, desk.answer, desk.unit)
        if any(new is not old for new, old in zip(shown, self._shown or (0, 0, 0), strict=True)):
            self._shown = shown
            self._draw()

    def _draw(self) -> None:
        desk = self._desk
        factor, symbol = 1.0 / SUFFIXES[desk.unit].factor, SYMBOLS[desk.unit]
        self._label(symbol)
        look, answer = desk.look, desk.answer
        self.marked.data = _columns("minute", "speed", "correction")
        if look is None:
            self.rows.data = _columns("minute", "speed", "height", "north", "east")
        else:
            low, high = float(np.min(look.height)) / FOOT, float(np.max(look.height)) / FOOT
            room = 0.05 * (high - low) + 1.0
            self.heights.update(start=low - room, end=high + room)
            self.rows.data = {
                "minute": look.minute,
                "speed": look.airspeed * factor,
                "height": look.height / FOOT,
                "north": look.north / _KILOMETER,
                "east": look.east / _KILOMETER,
            }
        if answer is None:
            for source in (self.used, self.curve, self.samples, self.points):
                source.data = _columns(*source.column_names)
            return
        self.used.data = {
            "begin": [begin for begin, _ in answer.spans],
            "end": [end for _, end in answer.spans],
        }
        curve = answer.curve
        value, bound = curve.correction * factor, curve.two_sigma * factor
        self.curve.data = {
            "speed": curve.indicated_airspeed * factor,
            "correction": value,
            "low": value - bound,
            "high": value + bound,
            "bound": bound,
        }
        minute, speed, correction = answer.samples
        self.samples.selected.indices = []
        self.samples.data = {
            "minute": minute,
            "speed": speed * factor,
            "correction": correction * factor,
        }
        self.points.data = {
            "speed": [p.indicated_airspeed * factor for p in answer.points],
            "correction": [p.correction * factor for p in answer.points],
            "low": [(p.correction - p.two_sigma) * factor for p in answer.points],
            "high": [(p.correction + p.two_sigma) * factor for p in answer.points],
            "method": [p.method for p in answer.points],
        }

    def _label(self, symbol: str) -> None:
        """Name the axes and the numbers at the pointer in a unit of speed."""
        self.time.yaxis[0].axis_label = self.error.xaxis.axis_label = (
            f"indicated airspeed [{symbol}]"
        )
        self.error.yaxis.axis_label = f"correction to add [{symbol}]"
        rows = [("minute", "@minute{0.00}"), ("airspeed", f"@speed{{0.0}} {symbol}"),
                ("altitude", "@height{0,0} ft")]  # fmt: skip
        self.time_hover.tooltips = rows
        self.track_hover.tooltips = [
            *rows, ("north", "@north{0.00} km"), ("east", "@east{0.00} km"),
        ]  # fmt: skip
        self.error_hover.tooltips = [
            ("indicated", f"@speed{{0}} {symbol}"), ("add", f"@correction{{+0.00}} {symbol}"),
            ("±2σ", f"@bound{{0.00}} {symbol}"),
        ]  # fmt: skip

    def _tapped(self, _attribute: str, _old: object, new: list[int]) -> None:
        """Light up the tapped samples in both pictures."""
        held = self.samples.data
        self.marked.data = {name: np.asarray(values)[new[:1]] for name, values in held.items()}

    def _brushed(self, event: Any) -> None:
        """Use the minutes of the brush, or leave them out."""
        if event.final and self._desk.look is not None:
            low, high = sorted((event.geometry["x0"], event.geometry["x1"]))
            last = float(self._desk.look.minute[-1])
            low, high = max(low, 0.0), min(high, last)
            moments = [minutes_text(_MINUTE * each) for each in (low, high)]
            if moments[0] != moments[1]:
                self._desk.brush(*moments)


def _columns(*names: str) -> dict[str, list[float]]:
    return {name: [] for name in names}


def _figure(x: str, y: str, height: int, tools: list[Any], **settings: Any) -> Any:
    plot = figure(
        height=height, sizing_mode="stretch_width", x_axis_label=x, y_axis_label=y,
        tools=[*tools, BoxZoomTool(), "pan", "reset"], toolbar_location="above",
        background_fill_color="white", min_border_left=10, **settings,
    )  # fmt: skip
    plot.toolbar.logo = None
    plot.grid.grid_line_color = "#E8E8E8"
    return plot


def open_document(desk: Desk, document: Document) -> View:
    """Fill a document of Bokeh with the view of a desk, and keep it so."""
    view = View(desk)
    document.title = "pitotbench"
    document.template = Template(own_file("page.html"))
    for name, model in (("time", view.time), ("track", view.track), ("error", view.error)):
        model.name = name
    for model in (view.time, view.track, view.error):
        document.add_root(model)
    view.render()

    def listen() -> None:
        document.add_next_tick_callback(view.render)

    desk.listeners.add(listen)
    document.on_session_destroyed(lambda _: desk.listeners.discard(listen))
    return view
