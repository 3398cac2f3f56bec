"""Read clock times and dates as seconds: HH:MM:SS, ISO 8601, day/month/year, and IRIG day:HH:MM:SS."""

import re
from datetime import UTC, date, datetime, time, timedelta

import numpy as np

from pitotbench.logbook.table import Column
from pitotbench.records.errors import BadInputError
from pitotbench.units import Array, Seconds

_DAY = 86400.0  # s
_MIDNIGHT = 0.5 * _DAY  # a clock without a date that runs back by more has passed midnight
_YEAR_ONE = date(1970, 1, 1).toordinal()
# An hour above 24 is IRIG's day of the year; the fraction may follow a point, a comma or a third colon.
_TIME = re.compile(r"(?:(\d{1,3}):)?(\d{1,2}):([0-5]?\d):([0-6]?\d(?:[.,]\d*)?)\s*([AaPp][Mm])?(?:Z|[+-]\d\d:?\d\d)?")
_MINUTES = re.compile(r"([0-5]?\d):([0-5]?\d(?:[.,]\d*)?)")
_ISO_DATE = re.compile(r"(\d{4})[-/.](\d{1,2})[-/.](\d{1,2})")
_ZONE = re.compile(r"(?:Z|[+-]\d\d:?\d\d)$")
_SLASHED = re.compile(r"(\d{1,2})[-/.](\d{1,2})[-/.](\d{4}|\d\d)")


def is_clock(column: Column) -> bool:
    """Return whether the first cell of a column that is not empty is a clock time or a date with one."""
    if column.dtype.kind in "mM":
        return True
    if column.dtype.kind not in "OU":
        return False
    first = next((cell for cell in column if not _blank(cell)), None)
    if isinstance(first, datetime | time | timedelta | np.datetime64):
        return True
    return first is not None and _reads(str(first))


def clock_seconds(name: str, column: Column) -> Seconds:
    """Return clock times as seconds, (n,): since 1970 with a date, else since midnight of the first day.

    A clock without a date that falls by more than half a day has passed midnight. Empty cells are NaN.
    Raises BadInputError that names the first row which is no clock time.
    """
    if column.dtype.kind in "mM":
        return np.asarray(column.astype("datetime64[ns]" if column.dtype.kind == "M" else "m8[ns]").astype(float) / 1e9)
    found = np.full((len(column), 2), np.nan)  # the day, and the second of it
    for row, cell in enumerate(column):
        if _blank(cell):
            continue
        try:
            found[row] = _day_and_second(cell)
        except ValueError:
            raise BadInputError(f"column {name!r}, row {row + 1}: {str(cell)!r} is not a clock time") from None
    known = np.isfinite(found[:, 1])
    day, second = found[known].T
    seconds = np.full(len(column), np.nan)
    seconds[known] = second + _DAY * (day if np.isfinite(day).all() else _days_passed(second))
    return seconds


def joined(dates: Column, times: Column) -> Column:
    """Return a column of dates and one of times as one column of both."""
    return np.array(
        ["" if _blank(a) or _blank(b) else f"{a} {b}" for a, b in zip(dates, times, strict=True)], dtype=object
    )


def _days_passed(second: Array) -> Array:
    return np.cumsum(np.diff(second, prepend=second[:1]) < -_MIDNIGHT).astype(np.float64)


def _blank(cell: object) -> bool:
    return cell is None or (isinstance(cell, float) and np.isnan(cell)) or not str(cell).strip()


def _reads(text: str) -> bool:
    try:
        _day_and_second(text)
    except ValueError:
        return False
    return True


def _day_and_second(cell: object) -> tuple[float, float]:
    """Return the day (NaN without a date) and the second of the day. Raises ValueError for anything else."""
    if isinstance(cell, timedelta):
        return np.nan, cell.total_seconds()
    text = str(cell).strip()
    day, rest = _day(text)
    if _ISO_DATE.match(text) and _ZONE.search(rest):
        moment = datetime.fromisoformat(text.replace(",", ".").replace(" ", "T", 1).replace(" ", "")).astimezone(UTC)
        return moment.toordinal() - _YEAR_ONE, moment.timestamp() % _DAY
    return _second(day, rest)


def _day(text: str) -> tuple[float, str]:
    """Return the day number of a leading date, and what follows it."""
    for pattern in (_ISO_DATE, _SLASHED):
        found = pattern.match(text)
        if found is None:
            continue
        year, month, day = map(int, found.groups() if pattern is _ISO_DATE else (found[3], found[1], found[2]))
        if month > 12:  # day before month; both are written, and only this one is possible
            month, day = day, month
        year += 2000 if year < 100 else 0
        return date(year, month, day).toordinal() - _YEAR_ONE, text[found.end() :].lstrip("T ,")
    return np.nan, text


def _second(day: float, text: str) -> tuple[float, float]:
    found = _TIME.fullmatch(text)
    if found is None:
        short = _MINUTES.fullmatch(text)
        if short is None:
            raise ValueError(text)
        return day, 60.0 * int(short[1]) + _number(short[2])
    number, hour, minute, second, half = found.groups()
    hours = int(hour)
    if half:
        hours = hours % 12 + (12 if half.lower() == "pm" else 0)
    if hours > 24:
        raise ValueError(text)
    return (float(number) if number else day), 3600.0 * hours + 60.0 * int(minute) + _number(second)


def _number(text: str) -> float:
    return float(text.replace(",", "."))
