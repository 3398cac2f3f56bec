"""A table as read from a file, not yet a log: names with units, clock times, a TOML header."""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, date, datetime, time, timedelta
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench.catalog import explain
from pitotbench.channels import CHANNELS, Channel
from pitotbench.records import BadInputError
from pitotbench.records.intake import toml_table
from pitotbench.records.outputs import atomic as atomic
from pitotbench.records.outputs import write_text as write_text
from pitotbench.units import SUFFIXES, Array, Booleans, Seconds

Column = NDArray[Any]
_CLOCK = re.compile(r"\d:[0-5]\d|\d{4}-\d\d-\d\d")  # 14:03:06 or 2026-05-04
_DECIMAL_COMMA = re.compile(r"\s*[+-]?\d*,\d+([eE][+-]?\d+)?\s*")


@dataclass(frozen=True, slots=True)
class Table:
    """Columns in the order of the file, the header, and the warnings of the reader.

    Two columns may have one name.
    """

    names: tuple[str, ...]
    columns: tuple[Column, ...]
    header: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    units: tuple[
        str, ...
    ] = ()  # of each column, as a line of units below that of the names states them

    def __len__(self) -> int:
        return len(self.columns[0]) if self.columns else 0

    def column(self, name: str) -> Column:
        """Return the column of a name. Raises BadInputError where it is missing or given twice."""
        count = self.names.count(name)
        if count != 1:
            raise BadInputError(
                f"column {name!r} is {'given twice; keep one' if count else 'missing'}"
            )
        return self.columns[self.names.index(name)]


def plain_name(name: str) -> str:
    """Return a column's name as recorders spell it alike: in lower case, with single blanks."""
    return " ".join(name.lower().replace("_", " ").split())


def numbers(name: str, column: Column) -> NDArray[np.float64]:
    """Return a column as floats, with NaN for empty cells.

    Raises BadInputError that names the first row whose cell is not a number.
    """
    if column.dtype.kind in "fiub":
        return np.asarray(column, dtype=np.float64)
    if column.dtype.kind in "mM" and len(column):
        raise BadInputError(f"column {name!r}, row 1: {_no_number(column[0])}")
    values = np.full(len(column), np.nan)
    for i, cell in enumerate(column):
        try:
            values[i] = (
                np.nan
                if cell is None or (isinstance(cell, str) and not cell.strip())
                else float(cell)
            )
        except (TypeError, ValueError):
            raise BadInputError(f"column {name!r}, row {i + 1}: {_no_number(cell)}") from None
    return values


_FEW_TEXTS = 0.05  # share of cells that hold a word in a column of numbers


def almost_numbers(column: Column) -> NDArray[np.float64] | None:
    """Return a column as floats where nearly all of its cells are numbers, else None.

    NaN stands for a blank and for a word, which is a slip there. A column that is blank gives None
    as well.
    """
    if column.dtype.kind in "fiu":
        return np.asarray(column, dtype=np.float64)
    values, words = np.full(len(column), np.nan), 0
    for row, cell in enumerate(column if column.dtype.kind in "OU" else ()):
        try:
            values[row] = float(cell) if cell is not None and str(cell).strip() else np.nan
        except (TypeError, ValueError):
            words += 1
    few = words <= _FEW_TEXTS * len(column)
    return values if few and np.isfinite(values).any() else None


def _no_number(cell: object) -> str:
    """Return why a cell is not a number, and what to write instead."""
    text = str(cell)
    if isinstance(cell, date | time | timedelta | np.datetime64 | np.timedelta64) or _CLOCK.search(
        text
    ):
        return f"{text!r} is a clock time or a date; write seconds from the start of the log"
    if _DECIMAL_COMMA.fullmatch(text):
        return f"{text!r} has a decimal comma; write decimal points in the whole file"
    return f"{text!r} is not a number; correct or remove that row"


_POSITION = re.compile(r"\s*([+-]?\d{1,2}\.\d{3,})[\s,;]+([+-]?\d{1,3}\.\d{3,})\s*")


def split_positions(table: Table) -> Table:
    """Return a table whose columns of positions are two columns each.

    One cell holds `latitude longitude` [°]; the two columns are named after the quantity. Cells of
    anything else are NaN.
    """
    kept: list[tuple[str, Column, str]] = []
    units = table.units or ("",) * len(table.names)
    for name, column, unit in zip(table.names, table.columns, units, strict=True):
        first = next((cell for cell in column if cell), "") if column.dtype.kind == "O" else ""
        if not _POSITION.fullmatch(str(first)):
            kept.append((name, column, unit))
            continue
        found = [_POSITION.fullmatch(str(cell)) for cell in column]
        for place, axis in enumerate(("latitude", "longitude"), 1):
            angles = np.array([float(cell[place]) if cell else np.nan for cell in found])
            kept.append((f"{name} {axis}", angles, "deg"))
    if len(kept) == len(table.names):
        return table
    names, columns, units = zip(*kept, strict=True)
    return Table(names, columns, table.header, table.warnings, units if table.units else ())


def flags(name: str, column: Column) -> NDArray[np.bool_]:
    """Return a column as booleans. Raises BadInputError for the first row that is neither."""
    if column.dtype.kind == "b" or (column.dtype.kind in "fiu" and np.isin(column, (0, 1)).all()):
        return np.asarray(column, dtype=np.bool_)
    words = {"true": True, "1": True, "1.0": True, "false": False, "0": False, "0.0": False}
    cells = [words.get(str(cell).lower()) for cell in column]
    if None in cells:
        row = cells.index(None)
        raise BadInputError(
            f"column {name!r}, row {row + 1}: {str(column[row])!r} is not true or false (1 or 0); "
            "correct that cell"
        )
    return np.array(cells, dtype=np.bool_)


_LONGEST_TEXT = 1000  # letters: an array of texts has room for the longest of them in each row


def texts(name: str, column: Column) -> Column:
    """Return a column as text; an empty cell is an empty text.

    The rows of a run share one text: as letters the labels of a long log outweigh ten columns.
    Raises BadInputError for a text that is no label.
    """
    if column.dtype.kind == "U":
        return column
    # labels come in long runs
    first = np.flatnonzero(np.r_[True, column[1:] != column[:-1]][: len(column)])
    cells = ["" if cell is None else str(cell) for cell in column[first]]
    longest = max(map(len, cells), default=0)
    if longest > _LONGEST_TEXT:
        raise BadInputError(
            f"column {name!r} holds a text of {longest:,} letters, where {_LONGEST_TEXT:,} are the "
            "most: shorten it"
        )
    return np.repeat(np.array(cells, dtype=object), np.diff(first, append=len(column)))


@contextmanager
def within(part: Path | str) -> Iterator[None]:
    """Put the file or the part of a log before an error of the block, or of its reading."""
    try:
        yield
    except BadInputError as error:
        raise type(error)(f"{part}: {error}") from error
    except OSError as error:
        raise BadInputError(f"{part}: cannot be read: {error.strerror or error}") from error


_MOST_COLUMNS = 10_000  # an airliner's recorder has some 3,000


def require_few_columns(count: int) -> None:
    """Raise BadInputError for more columns than a recorder writes.

    Minutes would be spent on their names.
    """
    if count > _MOST_COLUMNS:
        raise BadInputError(
            f"{count:,} columns, where {_MOST_COLUMNS:,} are the most: keep those of air data and "
            "GPS"
        )


# Read, but not kept: `derived` and `checks` turn them into channels of a log.
CONVERTED = (
    Channel("pa", "air", 5e3, 270e3, essential=True, name="total_pressure"),
    Channel("mps", "air", 0.0, 350.0, essential=True, name="indicated_airspeed"),
    Channel("mps", "air", 0.0, 350.0, essential=True, name="calibrated_airspeed"),
    Channel("mps", "air", 0.0, 350.0, essential=True, name="true_airspeed"),
    Channel("", "air", 0.0, 1.0, essential=True, name="mach"),
    Channel("m", "air", 0.0, 32e3, essential=True, name="pressure_altitude"),
    Channel("m", "air", 0.0, 32e3, essential=True, name="indicated_altitude"),
    Channel("m", "air", 0.0, 32e3, essential=True, name="height_above_takeoff"),
    Channel("pa", "air", 80e3, 120e3, essential=True, name="altimeter_setting"),
    Channel("mps", "gps", 0.0, 700.0, essential=True, name="ground_speed"),
    Channel("rad", "gps", 0.0, 2.0 * pi, essential=True, wraps=True, name="track"),
    Channel("rad", "gps", 0.0, 2.0 * pi, essential=True, wraps=True, name="magnetic_track"),
    Channel("rad", "gps", 0.0, 0.5 * pi, essential=True, name="latitude"),
    Channel("rad", "gps", 0.0, pi, essential=True, name="longitude"),
    Channel("rad", "inertial", 0.0, 2.0 * pi, wraps=True, name="magnetic_heading"),
    Channel("rad", "inertial", 0.0, pi, name="magnetic_variation"),
    *(Channel("", "inertial", 0.0, 1.0, name=f"attitude_q{place}") for place in range(4)),
    Channel("", "clock", 0.0, 0.0, essential=True, kind="text", name="clock_time"),
    Channel("", "clock", 0.0, 0.0, kind="text", name="date"),
    Channel("", "clock", 0.0, 0.0, kind="text", name="utc_offset"),
)
QUANTITIES: dict[str, Channel] = CHANNELS | {quantity.name: quantity for quantity in CONVERTED}
# Many logs hold these as well, with units of their own: without a known one they are
# not read.
OPTIONAL = ("true_airspeed", "mach", "latitude", "longitude", "utc_offset")
_LONGEST_FIRST = sorted(QUANTITIES, key=len, reverse=True)  # roll_rate before roll


def parse_column(column: str) -> tuple[Channel, str] | None:
    """Return the quantity and the unit suffix of a column name, None for one not in the table.

    Raises BadInputError for a quantity of the table whose unit is missing, unknown or of another
    dimension.
    """
    for name in _LONGEST_FIRST:
        remainder = column.removeprefix(name)
        # `altitude_m` is ours; `altitude_mean_m`, with two words after the quantity, is another
        # quantity.
        if remainder == column or (remainder and (remainder[0] != "_" or "_" in remainder[1:])):
            continue
        quantity, suffix = QUANTITIES[name], remainder[1:]
        if name in OPTIONAL and suffix not in (quantity.suffixes or [""]):
            return None
        _check_suffix(column, quantity, suffix)
        return quantity, suffix
    return None


def _check_suffix(column: str, quantity: Channel, suffix: str) -> None:
    if suffix in (quantity.suffixes or [""]):
        return
    if not quantity.unit:
        raise BadInputError(
            f"column {column!r}: {quantity.name} has no unit; name the column {quantity.name!r}"
        )
    usable = ", ".join(f"{quantity.name}_{s}" for s in quantity.suffixes)
    if not suffix:
        raise BadInputError(f"column {column!r} does not say its unit; name it {usable}")
    if suffix in SUFFIXES:
        raise BadInputError(
            f"column {column!r}: {suffix!r} is a unit of {SUFFIXES[suffix].dimension}, but "
            f"{quantity.name} is of {SUFFIXES[quantity.unit].dimension}; name it {usable}"
        )
    raise BadInputError(
        f"column {column!r}: {explain('unit suffix', suffix, list(SUFFIXES))} Name it {usable}."
    )


# A log may hold several airspeed sensors: `impact_pressure_2_pa` is the second one's.
_NUMBERED = re.compile(
    "((?:impact|total|static)_pressure|(?:indicated|calibrated)_airspeed)_([2-9])((?:_[a-z0-9]+)?)"
)


def numbered(name: str) -> tuple[str, int]:
    """Return a column's name without the number of its airspeed sensor, and that number, or 1."""
    found = _NUMBERED.fullmatch(name)
    return (found[1] + found[3], int(found[2])) if found else (name, 1)


_BEYOND = 2.0  # times the plausible range: a single value outside it is a glitch or a slip


def impossible(quantity: Channel, values: Array) -> Booleans:
    """Return where values [SI] of a quantity, (n,), are beyond what any airplane measures."""
    bad = np.abs(values) > _BEYOND * quantity.high
    return bad | (values < quantity.low / _BEYOND) if quantity.low > 0.0 else bad


# a table, or an entry of one
_TOML_LINE = re.compile(r"^\s*(\[.*\]\s*$|[\w.-]+\s*=\s*\S)", re.MULTILINE)
CALIBRATE = "calibrate"  # header entry: the choices of a calibration that the log's mapping advises
MAPPING = "mapping"  # header entry: the shipped mapping by which a log was recognized
AIR_DATA = "air_data"  # header entry: the air data computer whose output is calibrated
START = "start"  # header entry: date and time of day at which the seconds of the log begin
PLACE = "place"  # header entry: where the log was made, such as "47.91° N 97.03° W"
HEIGHT = "height"  # header entry: the stated height that was flown, such as "2000±300ft"
DAY = "temperature_c"  # header entry: the stated temperature of the day, such as "18±2@ground"
PARAMETERS = "parameters"  # header entry: the airspeed parameters with which an autopilot showed the log's airspeed
KIND = "aircraft_kind"  # header entry: what flew, where the recorder is of a kind: drone or glider
SENSOR = "airspeed_sensor"  # header entry: the number of the sensor of a log that holds several
WARNINGS = "warnings"  # header entry: remarks made when the log was read or written


def parse_header(text: str) -> tuple[dict[str, Any], list[str]]:
    """Return the table of a header and a list of warnings.

    Text that is not TOML is kept line by line, and warned of only where a line looks like TOML: the
    remarks that a recorder writes are none.
    """
    try:
        return toml_table(text), []
    except ValueError:
        meant = (
            ["the header's lines are not TOML; they are kept as text"]
            if _TOML_LINE.search(text)
            else []
        )
        return {"comments": text.splitlines()}, meant


def earlier_warnings(header: dict[str, Any]) -> list[str]:
    """Take the warnings out of a header, and return them.

    Entries that are not text are ignored, and a warning says so.
    """
    found = header.pop(WARNINGS, [])
    entries = found if isinstance(found, list | tuple) else [found]
    texts = [entry for entry in entries if isinstance(entry, str)]
    if len(texts) == len(entries):
        return texts
    return [*texts, "the header's `warnings` holds entries that are not text; they are ignored"]


SECONDS_A_DAY = 86400.0  # s
_MIDNIGHT = 0.5 * SECONDS_A_DAY  # a clock without a date that runs back by more has passed midnight
_YEAR_ONE = date(1970, 1, 1).toordinal()
# An hour above 24 is IRIG's day of the year; the fraction may follow a point, a comma or a third
# colon.
_TIME = re.compile(
    r"(?:(\d{1,3}):)?(\d{1,2}):([0-5]?\d):([0-6]?\d(?:[.,]\d*)?)\s*([AaPp][Mm])?(?:Z|[+-]\d\d:?\d\d)?"
)
_MINUTES = re.compile(r"([0-5]?\d):([0-5]?\d(?:[.,]\d*)?)")
_ISO_DATE = re.compile(r"(\d{4})[-/.](\d{1,2})[-/.](\d{1,2})")
_ZONE = re.compile(r"(?:Z|[+-]\d\d:?\d\d)$")
_ZONE_OFFSET = re.compile(r"([+-]?)(\d\d?):?(\d\d)")
_SLASHED = re.compile(r"(\d{1,2})[-/.](\d{1,2})[-/.](\d{4}|\d\d)")


def is_clock(column: Column) -> bool:
    """Return whether the first filled cell of a column is a clock time, with or without a date."""
    if column.dtype.kind in "mM":
        return True
    if column.dtype.kind not in "OU":
        return False
    first = next((cell for cell in column if not _blank(cell)), None)
    if first is None or isinstance(first, datetime | time | timedelta | np.datetime64):
        return first is not None
    try:
        _day_and_second(str(first))
    except ValueError:
        return False
    return True


def clock_seconds(name: str, column: Column) -> Seconds:
    """Return clock times as seconds, (n,), from 1970 with a date, else from the first midnight.

    A clock without a date that falls by more than half a day has passed midnight. Empty cells are
    NaN. Raises BadInputError that names the first row which is no clock time.
    """
    if column.dtype.kind in "mM":
        return np.asarray(
            column.astype("datetime64[ns]" if column.dtype.kind == "M" else "m8[ns]").astype(float)
            / 1e9
        )
    found = np.full((len(column), 2), np.nan)  # the day, and the second of it
    for row, cell in enumerate(column):
        if _blank(cell):
            continue
        try:
            found[row] = _day_and_second(cell)
        except ValueError:
            raise BadInputError(
                f"column {name!r}, row {row + 1}: {str(cell)!r} is not a clock time; correct that cell, "
                "or leave it blank"
            ) from None
    known = np.isfinite(found[:, 1])
    day, second = found[known].T
    seconds = np.full(len(column), np.nan)
    passed = np.cumsum(np.diff(second, prepend=second[:1]) < -_MIDNIGHT)
    seconds[known] = second + SECONDS_A_DAY * (day if np.isfinite(day).all() else passed)
    return seconds


def joined_clock(dates: Column, times: Column) -> Column:
    """Return a column of dates and one of times as one column of both."""
    return np.array(
        ["" if _blank(a) or _blank(b) else f"{a} {b}" for a, b in zip(dates, times, strict=True)],
        dtype=object,
    )


def zone_seconds(name: str, column: Column) -> Seconds:
    """Return the offsets of a local clock from UTC, such as `-05:00`, as seconds, (n,).

    A blank cell is NaN.

    Raises BadInputError that names the first row which is none.
    """
    found = {cell: _ZONE_OFFSET.fullmatch(str(cell).strip()) for cell in set(column)}
    for row, cell in enumerate(column):
        if found[cell] is None and not _blank(cell):
            raise BadInputError(
                f"column {name!r}, row {row + 1}: {str(cell)!r} is no offset from UTC (-05:00); "
                "correct that cell, or leave it blank"
            )
    seconds = {
        cell: np.nan
        if match is None
        else float(f"{match[1]}1") * (3600.0 * int(match[2]) + 60.0 * int(match[3]))
        for cell, match in found.items()
    }
    return np.array([seconds[cell] for cell in column])


def _blank(cell: object) -> bool:
    return cell is None or (isinstance(cell, float) and np.isnan(cell)) or not str(cell).strip()


def _day_and_second(cell: object) -> tuple[float, float]:
    """Return the day (NaN without a date) and the second of the day.

    Raises ValueError for anything else.
    """
    if isinstance(cell, timedelta):
        return np.nan, cell.total_seconds()
    text = str(cell).strip()
    day, remainder = _day(text)
    if _ISO_DATE.match(text) and _ZONE.search(remainder):
        moment = datetime.fromisoformat(
            text.replace(",", ".").replace(" ", "T", 1).replace(" ", "")
        ).astimezone(UTC)
        return moment.toordinal() - _YEAR_ONE, moment.timestamp() % SECONDS_A_DAY
    return _second(day, remainder)


def _day(text: str) -> tuple[float, str]:
    """Return the day number of a leading date, and what follows it."""
    for pattern in (_ISO_DATE, _SLASHED):
        found = pattern.match(text)
        if found is None:
            continue
        year, month, day = map(
            int, found.groups() if pattern is _ISO_DATE else (found[3], found[1], found[2])
        )
        if month > 12:  # day before month; both are written, and only this one is possible
            month, day = day, month
        year += 2000 if year < 100 else 0
        return date(year, month, day).toordinal() - _YEAR_ONE, text[found.end() :].lstrip("T ,")
    return np.nan, text


def _second(day: float, text: str) -> tuple[float, float]:
    found = _TIME.fullmatch(text := text.replace(",", "."))
    if found is None:
        short = _MINUTES.fullmatch(text)
        if short is None:
            raise ValueError(text)
        return day, 60.0 * int(short[1]) + float(short[2])
    number, hour, minute, second, half = found.groups()
    hours = int(hour)
    if half:
        hours = hours % 12 + (12 if half.lower() == "pm" else 0)
    if hours > 24:
        raise ValueError(text)
    return (float(number) if number else day), 3600.0 * hours + 60.0 * int(minute) + float(second)
