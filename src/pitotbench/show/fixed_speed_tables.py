"""Fixed-speed points in numbers: for the terminal, for pages, for programs. Loads no drawing library."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.fixed_speed_point import FixedSpeedPoint
from pitotbench.show.terminal import outside
from pitotbench.units import DEGREE, KNOT

_COLUMNS = (
    ("indicated\n[kt]", ".1f"), ("correction\n[kt]", "+.2f"), ("2σ\n[kt]", ".2f"), ("true\n[kt]", ".1f"),
    ("spread\n[kt]", ".2f"), ("wind\n[kt]", ".1f"), ("from\n[°]", "03.0f"), ("2σ\n[kt]", ".2f"),
    ("time\n[s]", ".0f"),
)  # fmt: skip


def print_points(points: Sequence[FixedSpeedPoint], console: Console, curve: ErrorCurve | None = None) -> None:
    """Print the points, one a row; with a curve, also by how much each differs from it. Nothing for no points."""
    if not points:
        return
    table = Table(
        header_style="bold", box=None, padding=(0, 1, 0, 0), title="fixed-speed methods", title_justify="left"
    )
    table.add_column("method", no_wrap=True)
    columns = (*_COLUMNS, *((("less\ncurve\n[kt]", "+.2f"),) if curve is not None else ()))
    for heading, _ in columns:
        table.add_column(escape(heading), justify="right", no_wrap=True)
    for point in points:
        values = [*_numbers(point), *([_off(point, curve)] if curve is not None else [])]
        cells = (_text(value, style) for value, (_, style) in zip(values, columns, strict=True))
        table.add_row(outside(method_words(point)), *cells)
    console.print(table)


def points_html(points: Sequence[FixedSpeedPoint]) -> str:
    """The same table, folded away, as HTML; empty for no points."""
    if not points:
        return ""
    head = "".join(f"<th>{h}</th>" for h in ("method", *(heading.replace("\n", " ") for heading, _ in _COLUMNS)))
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in _cells(point))}</tr>" for point in points)
    return (
        "<details><summary>Fixed-speed methods in numbers</summary>"
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div></details>'
    )


def points_json(points: Sequence[FixedSpeedPoint]) -> list[dict[str, Any]]:
    """The points as plain data, in knots, degrees and seconds."""
    keys = (
        "indicated_airspeed_kt", "correction_kt", "two_sigma_kt", "true_airspeed_kt", "spread_kt", "wind_speed_kt",
        "wind_from_deg", "wind_two_sigma_kt", "seconds",
    )  # fmt: skip
    return [
        {"method": point.method, "legs": point.legs}
        | dict(zip(keys, _numbers(point), strict=True))
        | {
            "calibrated_airspeed_kt": point.calibrated_airspeed / KNOT,
            "true_airspeed_two_sigma_kt": point.true_airspeed_two_sigma / KNOT,
        }
        for point in points
    ]


def method_words(point: FixedSpeedPoint) -> str:
    """The method's name as it is written in tables and legends."""
    return point.method.replace("_", "-")


def _numbers(point: FixedSpeedPoint) -> list[float | None]:
    """In the order of the columns, in their units."""
    wind_from = float(np.arctan2(-point.wind_east, -point.wind_north) / DEGREE) % 360.0
    wind = float(np.hypot(point.wind_north, point.wind_east))
    spread = None if point.spread is None else point.spread / KNOT
    speeds = (point.indicated_airspeed, point.correction, point.two_sigma, point.true_airspeed)
    in_knots = [speed / KNOT for speed in speeds]
    return [*in_knots, spread, wind / KNOT, wind_from, point.wind_two_sigma / KNOT, point.seconds]


def _cells(point: FixedSpeedPoint) -> list[str]:
    pairs = zip(_numbers(point), _COLUMNS, strict=True)
    return [method_words(point), *(_text(value, style) for value, (_, style) in pairs)]


def _text(value: float | None, style: str) -> str:
    return "–" if value is None else format(value, style)


def _off(point: FixedSpeedPoint, curve: ErrorCurve) -> float | None:
    """Correction less the curve's [kt]; None more than one step beyond the curve's ends."""
    from scipy.interpolate import CubicSpline

    speed, place = curve.indicated_airspeed, point.indicated_airspeed
    if len(speed) < 2 or not 2.0 * speed[0] - speed[1] <= place <= 2.0 * speed[-1] - speed[-2]:
        return None
    # Between round airspeeds a straight line is up to 0.03 kt off, more than a point in calm air.
    return float(point.correction - CubicSpline(speed, curve.correction)(place)) / KNOT
