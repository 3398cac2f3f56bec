"""The error curve of an answer as a picture that answers to the pointer: values on hover, zoom by dragging.

It needs the extra `interactive` (Plotly). Without it, without scripts and on paper the page shows the drawing.
"""

import json
from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np

from pitotbench.records.calibration import Calibration
from pitotbench.records.fixed_speed_point import FixedSpeedPoint
from pitotbench.show.error_curves import samples
from pitotbench.show.fixed_speed_tables import method_words
from pitotbench.show.limit import AUTO, Limit, limit_for
from pitotbench.show.style import BLUE, INK, RED
from pitotbench.units import KNOT, Array

_BAND = "rgba(0, 114, 178, 0.25)"
_LAYOUT = {
    "xaxis": {"title": {"text": "indicated airspeed [kt]"}, "gridcolor": "#E8E8E8"},
    "yaxis": {"title": {"text": "correction, CAS − IAS [kt]"}, "gridcolor": "#E8E8E8"},
    "legend": {"orientation": "h", "y": -0.3, "yanchor": "top", "itemsizing": "constant"},  # small dots are seen
    "margin": {"l": 60, "r": 10, "t": 36, "b": 50},  # the buttons stand above the data
    "font": {"family": "system-ui, sans-serif", "size": 12, "color": INK},
    "paper_bgcolor": "white",
    "plot_bgcolor": "white",
    "height": 400,
}
_CONFIG = {"responsive": True, "displaylogo": False, "modeBarButtonsToRemove": ["select2d", "lasso2d"]}
_MARKERS = {  # as in the drawing
    "turn": "circle",
    "four_leg": "square",
    "three_leg": "triangle-up",
    "horseshoe": "triangle-down",
    "many_leg": "diamond",
}
_DOT = "rgba(119, 119, 119, 0.35)"


def live_script() -> str:
    """The script that draws live pictures, some 5 MB for a page; empty without the extra `interactive`."""
    if find_spec("plotly") is None:
        return ""
    from plotly.offline import get_plotlyjs

    return str(get_plotlyjs())


def live_curve(
    result: Calibration, points: Sequence[FixedSpeedPoint] = (), limit: Limit | str | None = AUTO
) -> str:
    """The arguments of Plotly for the error curve, as JSON that may stand in a script; empty without the extra.

    They are the traces (the samples, the curve with its ±2σ, the limit, points of fixed-speed methods), the layout
    and the configuration. `limit` as for `judgments`.
    """
    if find_spec("plotly") is None:
        return ""
    drawn = [_samples(result), *_curve(result), *_limit(result, limit_for(result, limit)), *_points(points)]
    arguments = [drawn, _LAYOUT, _CONFIG]
    return json.dumps(arguments, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")


def _line(name: str, x: Array, y: Array, **other: Any) -> dict[str, Any]:
    return {"type": "scatter", "mode": "lines", "name": name, "x": x.tolist(), "y": y.tolist()} | other


def _samples(result: Calibration) -> dict[str, Any]:
    speed, data = (np.round(values, 2) for values in samples(result))
    look = {"mode": "markers", "marker": {"color": _DOT, "size": 2}, "hoverinfo": "skip"}
    return _line("samples without the wind", speed, data, **look)


def _curve(result: Calibration) -> list[dict[str, Any]]:
    curve = result.curve
    speed, value, bound = curve.indicated_airspeed / KNOT, curve.correction / KNOT, curve.two_sigma / KNOT
    edge = {"line": {"width": 0}, "hoverinfo": "skip"}
    hover = "%{x:.0f} KIAS: %{y:+.2f} ± %{customdata:.2f} kt<extra></extra>"
    return [
        _line("", speed, value - bound, showlegend=False, **edge),
        _line("±2σ of the curve", speed, value + bound, fill="tonexty", fillcolor=_BAND, **edge),
        _line(
            f"curve ({result.model})", speed, value,
            customdata=bound.tolist(), hovertemplate=hover, line={"color": BLUE},
        ),
    ]  # fmt: skip


def _limit(result: Calibration, limit: Limit | None) -> list[dict[str, Any]]:
    if limit is None:
        return []
    speed = result.curve.indicated_airspeed / KNOT
    hover = "%{x:.0f} KIAS: %{y:+.1f} kt<extra>limit</extra>"
    look = {"line": {"color": RED, "dash": "dot"}, "hovertemplate": hover}
    allowed = limit.airspeed(speed)
    return [_line(limit.label, speed, allowed, **look), _line("", speed, -allowed, showlegend=False, **look)]


def _points(points: Sequence[FixedSpeedPoint]) -> list[dict[str, Any]]:
    """One trace a method, so that each has an entry in the legend."""
    drawn = []
    for method in dict.fromkeys(point.method for point in points):
        chosen = [point for point in points if point.method == method]
        marker = {"color": "white", "size": 8, "symbol": _MARKERS[method], "line": {"color": INK, "width": 1}}
        drawn.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": f"{method_words(chosen[0])}, ±2σ",
                "x": [point.indicated_airspeed / KNOT for point in chosen],
                "y": [point.correction / KNOT for point in chosen],
                "error_y": {"type": "data", "array": [point.two_sigma / KNOT for point in chosen], "color": INK},
                "marker": marker,
            }
        )
    return drawn
