"""An error curve in rows: its table, the pilot's card, the samples, and fixed-speed points."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pitotbench.records.calibration import Calibration, ErrorCurve, PublishedCurve
from pitotbench.records.legs import FixedSpeedPoint
from pitotbench.show.calibration import doubts_of
from pitotbench.show.columns import Column, csv_text, json_rows, keyed, shown_columns
from pitotbench.show.tree import Doubt, Node, Sentence, Table
from pitotbench.units import DEGREE, FOOT, KNOT, SUFFIXES, MetersPerSecond, Seconds

CurvePoint = dict[str, float | None]  # a point of an error curve, by the keys of its columns


CURVE_COLUMNS = (
    keyed("indicated_airspeed_kt", "IAS", "kt", ".0f"),
    keyed("calibrated_airspeed_kt", "CAS", "kt", ".2f"),
    keyed("correction_kt", "correction", "kt", "+.2f"),
    keyed("two_sigma_kt", "±2σ bound", "kt", ".2f"),
    keyed("simultaneous_two_sigma_kt", "±2σ of whole curve", "kt", ".2f"),
    keyed("white_two_sigma_kt", "2σ for white residuals", "kt", ".2f"),
    keyed("normalized_pressure_error", "Δp/q_c", "", "+.4f"),
    keyed("normalized_two_sigma", "±2σ of Δp/q_c", "", ".4f"),
    keyed("handbook_correction_kt", "by the handbook", "kt", "+.1f", optional=True),
    keyed("altitude_correction_ft", "altitude correction", "ft", "+.0f", optional=True),
    keyed("two_sigma_ft", "±2σ of altitude", "ft", ".0f", optional=True),
)


def curve_points(curve: ErrorCurve) -> list[CurvePoint]:
    """The points of a curve, the rows of its table."""
    none = (None,) * len(curve.correction)
    altitude, altitude_bound = curve.altitude_correction, curve.altitude_two_sigma
    published = none if not curve.published else published_at(curve, curve.published[0]) / KNOT
    columns = {
        "indicated_airspeed_kt": curve.indicated_airspeed / KNOT,
        "calibrated_airspeed_kt": (curve.indicated_airspeed + curve.correction) / KNOT,
        "correction_kt": curve.correction / KNOT,
        "two_sigma_kt": curve.two_sigma / KNOT,
        "simultaneous_two_sigma_kt": curve.simultaneous_two_sigma / KNOT,
        "white_two_sigma_kt": curve.white_two_sigma / KNOT,
        "normalized_pressure_error": curve.normalized_pressure_error,
        "normalized_two_sigma": curve.normalized_two_sigma,
        "handbook_correction_kt": [None if v is None or np.isnan(v) else v for v in published],
        "altitude_correction_ft": none if altitude is None else altitude / FOOT,
        "two_sigma_ft": none if altitude_bound is None else altitude_bound / FOOT,
    }
    rows = zip(*columns.values(), strict=True)
    numbers = ([None if value is None else float(value) for value in row] for row in rows)
    return [dict(zip(columns, row, strict=True)) for row in numbers]


def published_at(curve: ErrorCurve, published: PublishedCurve) -> MetersPerSecond:
    """Return the correction by a handbook at the airspeeds of a curve [m/s], (n,).

    Outside its table the correction is NaN.
    """
    known = published.indicated_airspeed
    return np.interp(curve.indicated_airspeed, known, published.correction, np.nan, np.nan)


_MOST_DOTS = 900  # of the samples drawn: more make a page slow


def samples_of(result: Calibration) -> tuple[Seconds, MetersPerSecond, MetersPerSecond]:
    """Return time [s], indicated airspeed and correction [m/s] of at most some 900 samples, (n,).

    A sample's correction is the curve less the residual. The outermost 1 % of them are left out.
    """
    curve, residuals = result.curve, result.residuals
    thinned = slice(None, None, max(1, -(-len(residuals.time) // _MOST_DOTS)))
    speed = residuals.indicated_airspeed[thinned]
    data = (
        np.interp(speed, curve.indicated_airspeed, curve.correction) - residuals.airspeed[thinned]
    )
    low, high = np.quantile(data, [0.005, 0.995])
    shown = (data >= low) & (data <= high)
    return residuals.time[thinned][shown], speed[shown], data[shown]


_STEPS = (5, 10, 20, 50, 100)  # kt
MOST_ROWS = 13  # of a table that is read at one glance

_COLUMN = {column.key: column for column in CURVE_COLUMNS}
# What a pilot needs of the curve; the bound's digits say how many of the correction's mean
# something.
GLANCE_COLUMNS: tuple[Column[CurvePoint], ...] = (
    replace(_COLUMN["indicated_airspeed_kt"], heading="KIAS", unit=""),
    replace(_COLUMN["calibrated_airspeed_kt"], heading="KCAS", unit="", style=".1f"),
    _COLUMN["correction_kt"],
    replace(_COLUMN["two_sigma_kt"], heading="±2σ"),
    _COLUMN["handbook_correction_kt"],
    _COLUMN["altitude_correction_ft"],
    _COLUMN["two_sigma_ft"],
)


def glance_points(curve: ErrorCurve) -> list[CurvePoint]:
    """Return a curve's points at round airspeeds and its ends, few enough for one glance."""
    points = curve_points(curve)
    for step in _STEPS:
        inner = [p for p in points[1:-1] if round(p["indicated_airspeed_kt"] or 0.0) % step == 0]
        if len(shown := [*points[:1], *inner, *points[1:][-1:]]) <= MOST_ROWS:
            break
    return shown


def card_csv(result: Calibration, unit: str = "kt") -> str:
    """Return the card as CSV, with speeds in a unit such as `kmh`.

    The unit ends each column's name; all points of the curve are there. The first row has the
    doubts, the airplane and the day of the flight.
    """
    points, factor = curve_points(result.curve), KNOT / SUFFIXES[unit].factor
    columns = shown_columns(GLANCE_COLUMNS, points)

    def scaled(key: str, value: Any) -> object:
        return factor * value if key.endswith("_kt") and value is not None else value

    return csv_text(
        [
            {c.key.replace("_kt", f"_{unit}"): scaled(c.key, p[c.key]) for c in columns}
            for p in points
        ],
        doubts=" ".join(doubts_of(result)),
        airplane=result.provenance.airplane,
        flown_on=result.provenance.flown,
    )


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


def prior_sentences(priors: Mapping[str, float]) -> list[str]:
    """Return which priors were stated, as one sentence; none where all are the usual ones."""
    stated = ", ".join(f"{name} {value:g}" for name, value in priors.items())
    return [f"Priors that were stated: {stated}."] if stated else []


def points_tree(
    points: Sequence[FixedSpeedPoint], warnings: Iterable[str], priors: Mapping[str, float]
) -> list[Node]:
    """The points of a log by fixed-speed methods, and the stated priors of their bounds."""
    return [
        *map(Doubt, warnings),
        *map(Sentence, prior_sentences(priors)),
        Table(POINT_COLUMNS, points, "fixed-speed methods"),
    ]


def points_json(points: Sequence[FixedSpeedPoint]) -> list[dict[str, Any]]:
    """The points as plain data, in knots, degrees and seconds."""
    return json_rows(POINT_COLUMNS, points)


def off_curve(curve: ErrorCurve, point: FixedSpeedPoint) -> float | None:
    """The point's correction minus a curve's [kt]; None more than a step beyond its ends."""
    from scipy.interpolate import CubicSpline  # slow to import, and not needed for typed legs

    speed, place = curve.indicated_airspeed, point.indicated_airspeed
    if len(speed) < 2 or not 2.0 * speed[0] - speed[1] <= place <= 2.0 * speed[-1] - speed[-2]:
        return None
    # Between round airspeeds a straight line is up to 0.03 kt off, more than a point in calm air.
    return float(point.correction - CubicSpline(speed, curve.correction)(place)) / KNOT
