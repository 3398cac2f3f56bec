"""Read a card written by hand: a points table, one row a leg, or tower fly-bys, one row a pass."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.logbook.column_guesses import name_and_unit
from pitotbench.logbook.columns import (
    QUANTITIES,
    Column,
    Table,
    almost_numbers,
    impossible,
    numbers,
    parse_column,
    texts,
    within,
)
from pitotbench.logbook.displays import display_step
from pitotbench.logbook.formats import reader_of
from pitotbench.logbook.synonyms import SYNONYMS, UNIT_WORDS
from pitotbench.records import BadInputError
from pitotbench.records.legs import USUAL_STEPS, CardLeg, FlyBy, KnownSpeed, ReadingSteps
from pitotbench.units import FOOT, INCH_OF_MERCURY, KNOT, SUFFIXES, Array, from_si, to_si

POINT, CONFIGURATION, HEADING = "point", "configuration", "heading"
COLUMNS = (
    POINT,
    CONFIGURATION,
    "indicated_airspeed_kt",
    "pressure_altitude_ft",
    "air_temperature_degc",
    "ground_speed_kt",
    "track_deg",
)
FLY_BY_COLUMNS = (
    "indicated_airspeed_kt",
    "pressure_altitude_ft",
    "grid_height_ft",
    "tower_pressure_inhg",
    "tower_temperature_degc",
)
# The headings of the sheet that is filled in by hand, in small letters and without their units.
_OF_SHEET = {
    "kias": "indicated_airspeed_kt",
    "pressure altitude": "pressure_altitude_ft",
    "oat": "air_temperature_degc",
    "gps ground speed": "ground_speed_kt",
    "true track": "track_deg",
}
# Words of the name of a speed that something else than the airplane's own system measured.
_KNOWN = ("known", "tunnel", "reference", "ref", "pacer", "car", "truth", "actual")
_KNOWN_STEPS = {"known_airspeed": 0.1, "indicated_airspeed": 0.1}  # m/s
_QUANTITIES = (
    "indicated_airspeed",
    "pressure_altitude",
    "air_temperature",
    "ground_speed",
    "track",
)
_OF_GROUND = _QUANTITIES[3:]
_FLY_BY_STEPS = {
    "indicated_airspeed": KNOT,
    "pressure_altitude": 10.0 * FOOT,
    "grid_height": 5.0 * FOOT,
    "tower_pressure": 0.01 * INCH_OF_MERCURY,
    "tower_temperature": 1.0,
}
_OF_LEGS = ("indicated_airspeed_", "ground_speed_", ("track_", "heading_"))
_SAME_POINT = 3.0 * KNOT  # m/s, between the airspeeds of neighbors on a card without points
_OF_TOWER = {
    "grid_height": "length",
    "tower_pressure": "pressure",
    "tower_temperature": "temperature",
}

_FINEST = 0.02  # of the usual step: what was computed, not read, has steps too


def is_points_table(path: Path) -> bool:
    """Return whether a file is a points table: a CSV with `point` or legs, or fly-bys, and no time.

    Legs are airspeed, ground speed and direction.
    """
    names = _names(path)
    legs = all(any(n.startswith(each) for n in names) for each in _OF_LEGS)
    return (POINT in names or legs or is_fly_by_card(path)) and not any(
        n.startswith(("time_", "clock_time")) for n in names
    )


def is_known_speeds(path: Path) -> bool:
    """Return whether a file is a table of points with a known speed.

    Such a CSV has an airspeed or an impact pressure, a speed that is known, and no column that a
    log or a card of legs has.
    """
    names = [_of_known_speeds(name) for name in _names(path)]
    return (
        any(name.startswith("known_airspeed_") for name in names)
        and any(name.startswith(("indicated_airspeed_", "impact_pressure_")) for name in names)
        and not any(name.startswith(_OF_OTHERS) for name in names)
    )


def _of_known_speeds(name: str) -> str:
    """Return our name of a column of a table of points with a known speed.

    The names may be those of the field: `Tunnel speed [m/s]`, `IAS (kt)`. Another stays as it is.
    """
    words, written = name_and_unit(name)
    unit = next((suffix for suffix in SUFFIXES if written in UNIT_WORDS.get(suffix, ())), "")
    known = bool(words) and words[0] in _KNOWN and unit in _SPEEDS
    shown = (q for q in _SHOWN if not known and unit and "".join(words) in SYNONYMS[q].split())
    quantity = "known_airspeed" if known else next(shown, "")
    return f"{quantity}_{unit}" if quantity else name


def seems_a_calibration(path: Path) -> bool:
    """Return whether a file may be points of a sensor beside a known speed.

    Such a table is short, with few columns of numbers, none of which is a time.
    """
    with suppress(BadInputError):
        table = reader_of(path)(path)
        words = {word for name in table.names for word in name_and_unit(name)[0]}
        return (
            1 < len(table.names) <= _MOST_OF_POINTS
            and len(table) <= _MOST_POINTS
            and words.isdisjoint(SYNONYMS["time"].split())
            and all(almost_numbers(column) is not None for column in table.columns)
        )
    return False


def seems_fly_bys(path: Path) -> bool:
    """Return whether a file may be tower fly-bys under other names: of a grid, and of a tower."""
    words = {word for name in _names(path) for word in name_and_unit(name)[0]}
    return {"grid", "tower"} <= words


_SPEEDS = [suffix for suffix, unit in SUFFIXES.items() if unit.dimension == "speed"]
_SHOWN = ("indicated_airspeed", "impact_pressure")
_MOST_OF_POINTS = 5  # columns
_MOST_POINTS = 200  # rows: a longer table is a log
_OF_OTHERS = ("time_", "clock_time", "velocity_", "ground_speed_", "grid_height")


def is_fly_by_card(path: Path) -> bool:
    """Return whether a file is a card of tower fly-bys: a CSV with a grid height."""
    return any(name.startswith("grid_height") for name in _names(path))


def _names(path: Path) -> tuple[str, ...]:
    if path.suffix.lower() not in (".csv", ".xlsx") or not path.is_file():
        return ()
    try:
        return reader_of(path)(path).names
    except BadInputError:
        return ()


def read_points(path: Path) -> tuple[tuple[CardLeg, ...], ReadingSteps]:
    """Return a points table's legs in order, and the steps in which they were read.

    A card without tracks may have headings instead, `heading_deg`.

    Raises BadInputError, with the file, for a missing column or a cell that is no number.
    """
    names = [_parsed(name)[0] for name in _names(path)]
    by_heading = HEADING in names and "track" not in names
    rows, steps = _read(path, _QUANTITIES, COLUMNS[2:], asdict(USUAL_STEPS))
    return tuple(CardLeg(**row, by_heading=by_heading) for row in rows), ReadingSteps(**steps)


def read_ground_legs(path: Path) -> tuple[list[float], list[float]]:
    """Return the ground speeds [m/s] and the tracks [rad] of legs of which a file states no more.

    Raises BadInputError as `read_points` does.
    """
    rows, _ = _read(path, _OF_GROUND, COLUMNS[-2:], asdict(USUAL_STEPS))
    return [row["ground_speed"] for row in rows], [row["track"] for row in rows]


def read_fly_bys(path: Path) -> tuple[tuple[FlyBy, ...], dict[str, float]]:
    """Return the passes of a card of tower fly-bys, and the step [SI] of each quantity, by name.

    Raises BadInputError as `read_points` does.
    """
    rows, steps = _read(path, tuple(_FLY_BY_STEPS), FLY_BY_COLUMNS, _FLY_BY_STEPS)
    return tuple(FlyBy(**row) for row in rows), steps


def read_known_speeds(path: Path) -> tuple[tuple[KnownSpeed, ...], dict[str, float]]:
    """Return the points with a known speed of a table, and the step [m/s] of each speed.

    The steps are by name. An indicated impact pressure counts as the airspeed that it shows.

    Raises BadInputError as `read_points` does.
    """
    with within(path):
        table = reader_of(path)(path)
        names = tuple(map(_of_known_speeds, table.names))
        rows, steps = _rows(
            replace(table, names=names),
            tuple(_KNOWN_STEPS),
            ("known_airspeed_kt", "indicated_airspeed_kt"),
            _KNOWN_STEPS,
        )
    return tuple(KnownSpeed(**row) for row in rows), steps


def _read(
    path: Path, quantities: tuple[str, ...], columns: tuple[str, ...], usual: Mapping[str, float]
) -> tuple[list[dict[str, Any]], dict[str, float]]:
    """Return the rows of a card by the fields of their record, and the reading steps [SI]."""
    with within(path):
        return _rows(reader_of(path)(path), quantities, columns, usual)


def _rows(
    table: Table, quantities: tuple[str, ...], columns: tuple[str, ...], usual: Mapping[str, float]
) -> tuple[list[dict[str, Any]], dict[str, float]]:
    values: dict[str, Array] = {}
    suffixes: dict[str, str] = {}
    for name, column in zip(table.names, table.columns, strict=True):
        quantity, suffix = _parsed(name)
        if quantity in (*quantities, HEADING):
            values[quantity], suffixes[quantity] = to_si(numbers(name, column), suffix), suffix
        elif quantity == "impact_pressure" and "indicated_airspeed" in quantities:
            pressure = to_si(numbers(name, column), suffix)
            values["indicated_airspeed"] = np.asarray(
                air.calibrated_airspeed(np.maximum(pressure, 0.0))
            )
            suffixes["indicated_airspeed"] = "mps"
    if HEADING in values and "track" not in values:
        values["track"], suffixes["track"] = values[HEADING], suffixes[HEADING]
    missing = [column for column in columns if column.rpartition("_")[0] not in values]
    if missing:
        raise BadInputError(
            f"missing column{'s' if len(missing) > 1 else ''} {', '.join(missing)} of a points "
            "table"
        )
    blank = ~np.all([np.isfinite(values[name]) for name in quantities], axis=0)
    if blank.any():
        raise BadInputError(
            f"row {int(np.argmax(blank)) + 1}: a number is missing; fill it in or remove the leg"
        )
    # A track that cannot be is a slip. The reduction judges that, and the numbers of a tower.
    for name in [n for n in quantities if n in QUANTITIES and n != "track"]:
        bad = impossible(QUANTITIES[name], values[name])
        if bad.any():
            number = float(from_si(values[name][bad][0], suffixes[name]))
            raise BadInputError(
                f"row {int(np.argmax(bad)) + 1}: {name}_{suffixes[name]} is {number:.6g}, which no "
                "airplane measures; correct it or remove the row"
            )
    count = len(table)
    if any(cell[:1].isdigit() for cell in table.units):
        raise BadInputError(f"row 1: {table.units[0]!r} is not a number; write numbers alone")
    if not count:
        raise BadInputError("there is no row below the line of names; write a row a leg")
    configurations = (
        _labels(CONFIGURATION, table.column(CONFIGURATION))
        if CONFIGURATION in table.names
        else [""] * count
    )
    if POINT in table.names:
        points = _labels(POINT, table.column(POINT))
    elif quantities == _QUANTITIES:
        points = _by_airspeed(values["indicated_airspeed"], configurations)
    else:
        points = [str(i + 1) for i in range(count)]
    rows = [
        {
            "row": i + 1,
            "point": point,
            "configuration": name,
            **{n: float(values[n][i]) for n in quantities},
        }
        for i, (point, name) in enumerate(zip(points, configurations, strict=True))
    ]
    # The step of a usual display, where a short card shows a coarser one or none.
    steps = {name: display_step(values[name], suffixes[name]) for name in quantities}
    return rows, {
        n: step if _FINEST * usual[n] <= step < usual[n] else usual[n] for n, step in steps.items()
    }


def _by_airspeed(airspeed: Array, configurations: Sequence[str]) -> list[str]:
    """Return the points of legs by their airspeeds (n,) [m/s].

    A point has one configuration, and airspeeds that follow each other closely.
    """
    order = sorted(range(len(airspeed)), key=lambda i: (configurations[i], airspeed[i]))
    found, number = [""] * len(order), 1
    for last, i in zip([order[0], *order], order, strict=False):
        same = configurations[i] == configurations[last]
        number += not (same and airspeed[i] - airspeed[last] <= _SAME_POINT)
        found[i] = str(number)
    return found


def _parsed(name: str) -> tuple[str, str]:
    """Return the quantity of a column and its suffix; empty for another.

    Raises BadInputError for a wrong unit.
    """
    name = _OF_SHEET.get(name.partition("[")[0].strip().lower(), name)
    for quantity, dimension in _OF_TOWER.items():
        if name.startswith(quantity):
            suffix = name[len(quantity) + 1 :]
            if suffix not in SUFFIXES or SUFFIXES[suffix].dimension != dimension:
                known = ", ".join(
                    f"{quantity}_{s}" for s, unit in SUFFIXES.items() if unit.dimension == dimension
                )
                raise BadInputError(f"column {name!r}: a {dimension}; name it {known}")
            return quantity, suffix
    if name.startswith("known_airspeed"):
        return "known_airspeed", _parsed(name.replace("known", "indicated", 1))[1]
    turned = name.startswith(HEADING)  # in the units of a track
    parsed = (
        None
        if name in (POINT, CONFIGURATION)
        else parse_column(name.replace(HEADING, "track", 1) if turned else name)
    )
    return ("", "") if parsed is None else (HEADING if turned else parsed[0].name, parsed[1])


def _labels(name: str, column: Column) -> list[str]:
    if column.dtype.kind in "fiu":
        return [f"{value:g}" for value in column]
    return [str(text).strip() for text in texts(name, column)]
