"""The airspeed card: what to add at which indicated airspeed, for a terminal, a sheet and a file."""

from collections.abc import Sequence
from csv import writer
from dataclasses import replace
from io import StringIO
from urllib.parse import quote

from pitotbench.records.calibration import ErrorCurve
from pitotbench.show.columns import Column, html_table
from pitotbench.show.curve_table import CURVE_COLUMNS, CurvePoint, curve_points

_STEPS = (5, 10, 20, 50, 100)  # kt
_MOST_ROWS = 13  # of a table that is read at one glance

_COLUMN = {column.key: column for column in CURVE_COLUMNS}
# What a pilot needs of the curve; the bound's digits say how many of the correction's mean something.
GLANCE_COLUMNS: tuple[Column[CurvePoint], ...] = (
    replace(_COLUMN["indicated_airspeed_kt"], heading="KIAS", unit=""),
    replace(_COLUMN["calibrated_airspeed_kt"], heading="KCAS", unit="", style=".1f"),
    _COLUMN["correction_kt"],
    replace(_COLUMN["two_sigma_kt"], heading="±2σ"),
    _COLUMN["altitude_correction_ft"],
    _COLUMN["two_sigma_ft"],
)


def glance_points(curve: ErrorCurve) -> list[CurvePoint]:
    """The points of a curve at round airspeeds and at its ends, few enough to be read at one glance."""
    points = curve_points(curve)
    step = next((s for s in _STEPS if len(_at_step(points, s)) <= _MOST_ROWS), _STEPS[-1])
    return _at_step(points, step)


def card_html(curve: ErrorCurve, subject: str) -> str:
    """The card as an HTML table with a link that saves it as CSV."""
    data = quote(card_csv(curve))
    name = "".join(letter if letter.isalnum() else "-" for letter in subject) or "airspeed"
    link = f'<a download="card-{name}.csv" href="data:text/csv;charset=utf-8,{data}">Save as CSV</a>'
    return f'{html_table(GLANCE_COLUMNS, curve_points(curve))}<p class="save">{link}</p>'


def card_csv(curve: ErrorCurve) -> str:
    """The card as CSV: the unit ends each column's name; all points of the curve."""
    points = curve_points(curve)
    shown = [c for c in GLANCE_COLUMNS if not (c.optional and c.value(points[0]) is None)]
    text = StringIO()
    rows = writer(text, lineterminator="\n")
    rows.writerow(column.key for column in shown)
    rows.writerows([_rounded(column, point) for column in shown] for point in points)
    return text.getvalue()


def _rounded(column: Column[CurvePoint], point: CurvePoint) -> str:
    value = column.value(point)
    return "" if value is None else format(value, ".3f")


def _at_step(points: Sequence[CurvePoint], step: int) -> list[CurvePoint]:
    """The points at multiples of a step [kt], with the first and the last one."""
    ends = {points[0].number, points[-1].number}
    return [p for p in points if p.number in ends or round(p.knots(p.curve.indicated_airspeed)) % step == 0]
