"""The page as a document of Bokeh: four pictures, and the texts of the desk for its script."""

import json
from collections.abc import Mapping, Sequence
from functools import partial
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.events import SelectionGeometry
from bokeh.models import (
    BoxSelectTool,
    ColumnDataSource,
    DataRange1d,
    HoverTool,
    LinearAxis,
    Span,
    TapTool,
)
from bokeh.plotting import figure
from jinja2 import Template

from pitotbench.browser.desk import Desk
from pitotbench.browser.words import state_of
from pitotbench.show.curve_rows import samples_of
from pitotbench.timeline import minutes_text
from pitotbench.units import MINUTE, SUFFIXES, SYMBOLS

# Okabe and Ito (2008): colors for all kinds of color vision; the kinds of lines differ as well.
_BLUE = "#0072B2"
_ORANGE = "#B36200"  # darker than theirs, for thin lines and numbers on white
_GREEN = "#009E73"
_INK = "#222222"
_GRAY = "#777777"
_TALL = 270  # px
_FAINT = 0.15  # opacity of an area behind the lines
_ROOM = 50.0  # of the unit of length, above and below the heights flown
_KILOMETER = 1000.0  # m
_AT_SPEEDS = {"slow": _BLUE, "middle": _ORANGE, "fast": _GREEN}  # of the course over dates
_COLUMNS = {  # of the data of each part of the pictures
    "flight": ("minute", "speed", "height", "north", "east"),
    "used": ("begin", "end"),
    "curve": ("speed", "correction", "low", "high", "bound"),
    "samples": ("minute", "speed", "correction"),
    "legs": ("speed", "correction", "low", "high"),
    "handbook": ("speed", "correction"),
    "marked": ("minute", "speed", "correction"),
    **dict.fromkeys(_AT_SPEEDS, ("date", "correction", "low", "high")),
    "changed": ("date",),
}
_FLIGHT = {
    "minute": "@minute{0.00}",
    "airspeed": "@speed{0.0} UNIT",
    "altitude": "@height{0,0} LENGTH",
}
_AT_THE_POINTER = {
    "time": _FLIGHT,
    "track": _FLIGHT | {"north": "@north{0.00} km", "east": "@east{0.00} km"},
    "error": {
        "indicated": "@speed{0} UNIT",
        "add": "@correction{+0.00} UNIT",
        "±2σ": "@bound{0.00} UNIT",
    },
}
_MARK: Mapping[str, str | float] = {
    "size": 12,
    "marker": "diamond",
    "fill_color": _ORANGE,
    "line_color": _INK,
}
_LEG: Mapping[str, str | float] = {
    "size": 8,
    "marker": "square",
    "fill_color": "white",
    "line_color": _INK,
}
_DASHED = {"color": _ORANGE, "line_dash": "dashed", "y_range_name": "height"}
_SAMPLE: Mapping[str, str | float] = {"color": _GRAY, "alpha": 0.4}
_HANDBOOK = {"color": _ORANGE, "line_dash": "dashed"}
_CHANGED = {"color": _GRAY, "line_dash": "dashed"}


# By picture, kind of drawing in Bokeh and name of the data: the columns that are drawn, and how they
# look. What is drawn later lies above.
_GLYPHS: dict[tuple[str, str, str], tuple[tuple[str, ...], Mapping[str, str | float]]] = {
    ("time", "vstrip", "used"): (("begin", "end"), {"color": _GREEN, "alpha": _FAINT}),
    ("time", "step", "flight"): (("minute", "height"), _DASHED),
    ("time", "line", "flight"): (("minute", "speed"), {"color": _BLUE}),
    ("time", "scatter", "marked"): (("minute", "speed"), _MARK),
    ("track", "line", "flight"): (("east", "north"), {"color": _BLUE}),
    ("error", "varea", "curve"): (("speed", "low", "high"), {"color": _BLUE, "alpha": _FAINT}),
    ("error", "scatter", "samples"): (("speed", "correction"), _SAMPLE),
    ("error", "line", "curve"): (("speed", "correction"), {"color": _BLUE, "line_width": 2}),
    ("error", "line", "handbook"): (("speed", "correction"), _HANDBOOK),
    # A glyph counts for the range of the axis: no leg's bar is cut, as one of an annotation is.
    ("error", "segment", "legs"): (("speed", "low", "speed", "high"), {"color": _INK}),
    ("error", "scatter", "legs"): (("speed", "correction"), _LEG),
    ("error", "scatter", "marked"): (("speed", "correction"), _MARK),
    ("dates", "vspan", "changed"): (("date",), _CHANGED),
    **{
        ("dates", kind, name): (columns, {"color": color, **look})
        for name, color in _AT_SPEEDS.items()
        for kind, columns, look in (
            ("segment", ("date", "low", "date", "high"), {}),
            ("scatter", ("date", "correction"), {"size": 7}),
        )
    },
}


def own_folder() -> str:
    """Return the folder of the page's template, script and style."""
    return str(resources.files("pitotbench.browser") / "page")


def picture_data(desk: Desk) -> dict[str, tuple[Any, ...]]:
    """Return what the pictures of a desk show, in the order of `_COLUMNS` by name.

    Speeds and heights are in the units of the desk, ways in kilometers.
    """
    unit, length = (SUFFIXES[each].factor for each in (desk.units.speed, desk.units.length))
    data: dict[str, tuple[Any, ...]] = {name: ((),) * len(c) for name, c in _COLUMNS.items()}
    if desk.look is not None:
        look = desk.look[1]
        way = (look.north / _KILOMETER, look.east / _KILOMETER)
        data["flight"] = (look.minute, look.airspeed / unit, look.height / length, *way)
    if desk.answer is not None:
        result = desk.answer.result
        time, speed, correction = samples_of(result)
        minutes = (time - result.log_start) / MINUTE
        spans = (np.array(desk.answer.spans) - result.log_start) / MINUTE
        legs = [_with_bound(point, unit)[:-1] for point in result.points]
        # NaN between the lines of two configurations.
        books = [
            np.pad(
                [each.indicated_airspeed, each.correction], ((0, 0), (0, 1)), constant_values=np.nan
            )
            for each in result.curve.published
        ]
        answered = {
            "used": tuple(spans.T),
            "curve": _with_bound(result.curve, unit),
            "samples": (minutes, speed / unit, correction / unit),
            "legs": tuple(zip(*legs, strict=True)),
            "handbook": tuple(np.hstack(books) / unit) if books else (),
        }
        data |= {name: columns for name, columns in answered.items() if columns}
    if (course := desk.course) is not None:
        dates = np.array([each.replace(tzinfo=None) for each in course.dates], "datetime64[ms]")
        for name, value, bound in zip(
            _AT_SPEEDS, course.correction.T, course.two_sigma.T, strict=True
        ):
            data[name] = (dates, value / unit, (value - bound) / unit, (value + bound) / unit)
        if course.change is not None:
            first = course.change.first
            data["changed"] = (dates[first - 1 : first] + (dates[first] - dates[first - 1]) / 2,)
    return data


def _with_bound(curve: Any, unit: float) -> tuple[Any, ...]:
    """Airspeed, correction, its lower and upper end, and the bound, of a curve or of a point."""
    value, bound = curve.correction / unit, curve.two_sigma / unit
    return curve.indicated_airspeed / unit, value, value - bound, value + bound, bound


def _figure(name: str, x: str, y: str, zoom: str, **settings: Any) -> Any:
    plot = figure(
        name=name,
        height=_TALL,
        sizing_mode="stretch_width",
        x_axis_label=x,
        y_axis_label=y,
        tools=[zoom, "box_zoom", "pan", "reset"],
        toolbar_location="above",
        min_border_left=10,
        **settings,
    )
    plot.toolbar.logo = None
    plot.grid.grid_line_color = "#E8E8E8"
    return plot


class View:
    """A desk's pictures in one tab: `time`, `track`, `error` with its bound, and `dates`.

    Over `time` are airspeed and height, over `dates` the correction of several flights.
    """

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._shown: tuple[object, ...] = ()
        self.data = {
            name: ColumnDataSource({column: [] for column in columns})
            for name, columns in _COLUMNS.items()
        }
        height = DataRange1d(range_padding=_ROOM, range_padding_units="absolute")
        self.time = _figure(
            "time", "time [min]", "", "xwheel_zoom", extra_y_ranges={"height": height}
        )
        self.track = _figure("track", "east [km]", "north [km]", "wheel_zoom", match_aspect=True)
        self.error = _figure("error", "", "", "wheel_zoom")
        self.dates = _figure("dates", "date (UTC)", "", "xwheel_zoom", x_axis_type="datetime")
        drawn = {
            (picture, kind, data): getattr(getattr(self, picture), kind)(
                *columns, source=self.data[data], **look
            )
            for (picture, kind, data), (columns, look) in _GLYPHS.items()
        }
        speed, dots = drawn["time", "line", "flight"], drawn["error", "scatter", "samples"]
        dots.nonselection_glyph = dots.glyph
        self.time.y_range.renderers = [speed]
        height.renderers = [drawn["time", "step", "flight"]]
        self.time.toolbar.active_drag = brush = BoxSelectTool(
            dimensions="width", renderers=[], description="brush minutes"
        )
        self.time.add_tools(brush, HoverTool(renderers=[speed], mode="vline"))
        self.track.add_tools(HoverTool(renderers=[drawn["track", "line", "flight"]]))
        self.error.add_tools(
            TapTool(renderers=[dots]),
            HoverTool(renderers=[drawn["error", "line", "curve"]], mode="vline"),
        )
        self.time.add_layout(LinearAxis(y_range_name="height"), "right")
        for picture in (self.error, self.dates):
            picture.add_layout(Span(location=0.0, dimension="width", line_width=1))
        self.data["samples"].selected.on_change("indices", self._tapped)
        self.time.on_event(SelectionGeometry, self._brushed)

    def render(self) -> None:
        """Show the desk as it is now; what has not changed stays, with its zoom."""
        desk = self._desk
        # A property that nothing draws: the texts are no HTML.
        self.time.tags = [json.dumps(state_of(desk), allow_nan=False)]
        shown = (desk.look, desk.answer, desk.course, desk.units)
        if [*map(id, shown)] != [*map(id, self._shown)]:
            self._shown = shown
            self.data["samples"].selected.indices = []
            for name, columns in picture_data(desk).items():
                self.data[name].data = dict(zip(_COLUMNS[name], columns, strict=True))
            self._label(SYMBOLS[desk.units.speed], SYMBOLS[desk.units.length])

    def _label(self, unit: str, length: str) -> None:
        """Name the axes and the numbers at the pointer."""
        self.time.right[0].axis_label = f"pressure altitude [{length}]"
        self.time.yaxis[0].axis_label = self.error.xaxis.axis_label = f"indicated airspeed [{unit}]"
        self.error.yaxis.axis_label = f"correction to add [{unit}]"
        self.dates.yaxis.axis_label = self.error.yaxis[0].axis_label
        for name, rows in _AT_THE_POINTER.items():
            getattr(self, name).select_one(HoverTool).tooltips = [
                (label, text.replace("UNIT", unit).replace("LENGTH", length))
                for label, text in rows.items()
            ]

    def _tapped(self, _attribute: str, _old: object, new: Sequence[int]) -> None:
        """Light up the tapped sample in both pictures."""
        self.data["marked"].data = {
            name: np.asarray(values)[list(new[:1])]
            for name, values in self.data["samples"].data.items()
        }

    def _brushed(self, event: Any) -> None:
        """Use the minutes of the brush, or leave them out."""
        if event.final and self._desk.look is not None:
            last = float(self._desk.look[1].minute[-1])
            ends = sorted(min(max(event.geometry[name], 0.0), last) for name in ("x0", "x1"))
            labels = [minutes_text(MINUTE * minute) for minute in ends]
            if labels[0] != labels[1]:
                # Up to an end of the log is all up to there.
                whole = [] if self._desk.leave_out else ["0:00", minutes_text(MINUTE * last)]
                self._desk.brush(*("" if each in whole else each for each in labels))


def open_document(desk: Desk, document: Document) -> View:
    """Fill a document of Bokeh with the view of a desk, and keep it so."""
    view = View(desk)
    document.title = "pitotbench"
    document.template = Template(Path(own_folder(), "page.html").read_text(encoding="utf-8"))
    for picture in (view.time, view.track, view.error, view.dates):
        document.add_root(picture)
    view.render()
    listen = partial(document.add_next_tick_callback, view.render)
    desk.listeners.add(listen)
    document.on_session_destroyed(lambda _: desk.listeners.discard(listen))
    return view
