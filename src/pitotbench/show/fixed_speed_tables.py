"""Fixed-speed points in numbers: for the terminal, for pages, for programs. Loads no drawing library."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.fixed_speed_point import FixedSpeedPoint
from pitotbench.show.columns import Column, html_table, json_rows, print_table
from pitotbench.units import DEGREE, KNOT

if TYPE_CHECKING:
    from rich.console import Console


def method_words(point: FixedSpeedPoint) -> str:
    """The method's name as it is written in tables and legends."""
    return point.method.replace("_", "-")


POINT_COLUMNS: tuple[Column[FixedSpeedPoint], ...] = (
    Column("method", method_words),
    Column("", lambda p: p.method, key="method"),
    Column("", lambda p: p.legs, key="legs"),
    Column("IAS", lambda p: p.indicated_airspeed / KNOT, "kt", ".1f", "indicated_airspeed_kt"),
    Column("CAS", lambda p: p.calibrated_airspeed / KNOT, "kt", ".1f", "calibrated_airspeed_kt"),
    Column("correction", lambda p: p.correction / KNOT, "kt", "+.2f", "correction_kt"),
    Column("±2σ bound", lambda p: p.two_sigma / KNOT, "kt", ".2f", "two_sigma_kt"),
    Column("TAS", lambda p: p.true_airspeed / KNOT, "kt", ".1f", "true_airspeed_kt"),
    Column("", lambda p: p.true_airspeed_two_sigma / KNOT, key="true_airspeed_two_sigma_kt"),
    Column("spread", lambda p: None if p.spread is None else p.spread / KNOT, "kt", ".2f", "spread_kt"),
    Column("wind", lambda p: float(np.hypot(p.wind_north, p.wind_east)) / KNOT, "kt", ".1f", "wind_speed_kt"),
    Column(
        "from", lambda p: float(np.arctan2(-p.wind_east, -p.wind_north) / DEGREE) % 360.0, "°", "03.0f",
        "wind_from_deg",
    ),
    Column("±2σ of wind", lambda p: p.wind_two_sigma / KNOT, "kt", ".2f", "wind_two_sigma_kt"),
    Column("time", lambda p: p.seconds, "s", ".0f", "seconds"),
)  # fmt: skip


def print_points(points: Sequence[FixedSpeedPoint], console: "Console", curve: ErrorCurve | None = None) -> None:
    """Print the points, one a row; with a curve, also the difference of each from it. Nothing for no points."""
    if points and curve is not None:
        console.print()  # the curve stands above
    print_table(point_columns(curve), points, console, "fixed-speed methods")


def points_html(points: Sequence[FixedSpeedPoint], curve: ErrorCurve | None = None) -> str:
    """The same table, folded away, as HTML; empty for no points."""
    if not points:
        return ""
    table = html_table(point_columns(curve), points)
    return f"<details><summary>Fixed-speed methods in numbers</summary>{table}</details>"


def points_json(points: Sequence[FixedSpeedPoint]) -> list[dict[str, Any]]:
    """The points as plain data, in knots, degrees and seconds."""
    return json_rows(POINT_COLUMNS, points)


def point_columns(curve: ErrorCurve | None) -> list[Column[FixedSpeedPoint]]:
    """The columns of the points; with a curve, also the point's correction minus that of the curve."""
    if curve is None:
        return list(POINT_COLUMNS)
    return [*POINT_COLUMNS, Column("point − curve", lambda point: _off(point, curve), "kt", "+.2f")]


def legs_json(true_airspeed: float, spread: float | None, wind_speed: float, wind_from: float) -> dict[str, Any]:
    """The answer of legs that were typed by hand: true airspeed, spread and wind speed [m/s] and the direction
    [rad] that the wind comes from, as plain data in knots and degrees."""
    return {
        "true_airspeed_kt": true_airspeed / KNOT,
        "spread_kt": None if spread is None else spread / KNOT,
        "wind_speed_kt": wind_speed / KNOT,
        "wind_from_deg": wind_from / DEGREE,
    }


def _off(point: FixedSpeedPoint, curve: ErrorCurve) -> float | None:
    """The difference [kt]; None more than one step beyond the curve's ends."""
    from scipy.interpolate import CubicSpline  # slow to import, and not needed for typed legs

    speed, place = curve.indicated_airspeed, point.indicated_airspeed
    if len(speed) < 2 or not 2.0 * speed[0] - speed[1] <= place <= 2.0 * speed[-1] - speed[-2]:
        return None
    # Between round airspeeds a straight line is up to 0.03 kt off, more than a point in calm air.
    return float(point.correction - CubicSpline(speed, curve.correction)(place)) / KNOT
