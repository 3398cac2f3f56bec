"""A card written by hand, in numbers: for the terminal and as plain data."""

from typing import Any

import numpy as np
from rich.console import Console

from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.hand_card import CardPoint, HandCard
from pitotbench.show.columns import Column, json_rows, print_table
from pitotbench.show.terminal import print_warnings
from pitotbench.units import DEGREE, FOOT, KNOT


def _scaled(value: float | None, unit: float) -> float | None:
    return None if value is None else value / unit


POINT_COLUMNS: tuple[Column[CardPoint], ...] = (
    Column("point", lambda p: p.point, key="point"),
    Column("configuration", lambda p: p.configuration or None, key="configuration", optional=True),
    Column("legs", lambda p: p.legs, "", "d", "legs"),
    Column("KIAS", lambda p: p.indicated_airspeed / KNOT, "kt", ".1f", "indicated_airspeed_kt"),
    Column("KCAS", lambda p: _scaled(p.calibrated_airspeed, KNOT), "kt", ".1f", "calibrated_airspeed_kt"),
    Column("correction", lambda p: _scaled(p.correction, KNOT), "kt", "+.2f", "correction_kt"),
    Column("±2σ", lambda p: _scaled(p.two_sigma, KNOT), "kt", ".2f", "two_sigma_kt"),
    Column(
        "altitude correction",
        lambda p: _scaled(p.altitude_correction, FOOT),
        "ft",
        "+.0f",
        "altitude_correction_ft",
    ),
    Column("±2σ", lambda p: _scaled(p.altitude_two_sigma, FOOT), "ft", ".0f", "altitude_two_sigma_ft"),
    Column("KTAS", lambda p: _scaled(p.true_airspeed, KNOT), "kt", ".1f", "true_airspeed_kt"),
    Column("spread", lambda p: _scaled(p.spread, KNOT), "kt", ".2f", "spread_kt"),
    Column("wind", lambda p: _scaled(p.wind_speed, KNOT), "kt", ".1f", "wind_speed_kt"),
    Column("from", lambda p: _scaled(p.wind_from, DEGREE), "°", "03.0f", "wind_from_deg"),
    Column("remark", lambda p: p.remark, key="remark"),
)
_CurveRow = tuple[float, float, float, float, float, float, float, float]
CURVE_COLUMNS: tuple[Column[_CurveRow], ...] = (
    Column("KIAS", lambda r: r[0], "kt", ".1f", "indicated_airspeed_kt"),
    Column("KCAS", lambda r: r[1], "kt", ".1f", "calibrated_airspeed_kt"),
    Column("correction", lambda r: r[2], "kt", "+.2f", "correction_kt"),
    Column("±2σ", lambda r: r[3], "kt", ".2f", "two_sigma_kt"),
    Column("altitude correction", lambda r: r[4], "ft", "+.0f", "altitude_correction_ft"),
    Column("±2σ", lambda r: r[5], "ft", ".0f", "altitude_two_sigma_ft"),
    Column("Δp/q_c", lambda r: r[6], "", "+.4f", "normalized_pressure_error"),
    Column("", lambda r: r[7], key="normalized_two_sigma"),
)


def _rows(curve: ErrorCurve) -> list[_CurveRow]:
    height = np.zeros(len(curve.correction)) if curve.altitude_correction is None else curve.altitude_correction
    bound = np.zeros(len(curve.correction)) if curve.altitude_two_sigma is None else curve.altitude_two_sigma
    columns = (
        curve.indicated_airspeed / KNOT,
        (curve.indicated_airspeed + curve.correction) / KNOT,
        curve.correction / KNOT,
        curve.two_sigma / KNOT,
        height / FOOT,
        bound / FOOT,
        curve.normalized_pressure_error,
        curve.normalized_two_sigma,
    )
    return [tuple(map(float, row)) for row in zip(*columns, strict=True)]  # type: ignore[misc]


def print_card(card: HandCard, console: Console) -> None:
    """Print the slips, the points, and the curve of each configuration."""
    print_warnings(card.warnings, console)
    print_table(POINT_COLUMNS, card.points, console, "points")
    for name, curve in card.curves.items():
        console.print()
        print_table(CURVE_COLUMNS, _rows(curve), console, f"curve{f', {name}' if name else ''}")


def card_json(card: HandCard) -> dict[str, Any]:
    """The card as plain data, in knots, feet and degrees."""
    return {
        "points": json_rows(POINT_COLUMNS, card.points),
        "curves": {name: {"curve": json_rows(CURVE_COLUMNS, _rows(curve))} for name, curve in card.curves.items()},
        "slips": [
            {"row": s.row, "point": s.point, "what": s.words, "probably": s.probably or None} for s in card.slips
        ],
        "warnings": list(card.warnings),
    }
