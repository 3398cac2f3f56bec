"""Read a points table: a card written by hand, one row a leg."""

from pathlib import Path

import numpy as np

from pitotbench.logbook.columns import Column, Table, numbers, parse_column, texts
from pitotbench.logbook.csv import read_csv
from pitotbench.logbook.derived import display_step
from pitotbench.records import BadInputError
from pitotbench.records.legs import CardLeg, ReadingSteps
from pitotbench.units import DEGREE, FOOT, KNOT, Array, to_si

POINT, CONFIGURATION = "point", "configuration"
COLUMNS = (
    POINT,
    CONFIGURATION,
    "indicated_airspeed_kt",
    "pressure_altitude_ft",
    "air_temperature_degc",
    "ground_speed_kt",
    "track_deg",
)
_QUANTITIES = ("indicated_airspeed", "pressure_altitude", "air_temperature", "ground_speed", "track")
# The steps of usual displays, where the numbers of a short card show none [SI].
_ROUND_STEPS = ReadingSteps(KNOT, 10.0 * FOOT, 1.0, KNOT, DEGREE)

_FINEST = 0.02  # of the usual step: what was computed, not read, has steps too


def is_points_table(path: Path) -> bool:
    """Return whether a file is a points table: a CSV with a column `point` and none of time."""
    if path.suffix.lower() != ".csv" or not path.is_file():
        return False
    try:
        names = read_csv(path).names
    except BadInputError:
        return False
    return POINT in names and not any(name.startswith(("time_", "clock_time")) for name in names)


def read_points(path: Path) -> tuple[tuple[CardLeg, ...], ReadingSteps]:
    """Return the legs of a points table in their order, and the steps in which they were read.

    Raises BadInputError, with the file, for a missing column or a cell that is no number.
    """
    try:
        return _legs(read_csv(path))
    except BadInputError as error:
        raise BadInputError(f"{path}: {error}") from error
    except OSError as error:
        raise BadInputError(f"{path}: cannot be read: {error.strerror or error}") from error


def _legs(table: Table) -> tuple[tuple[CardLeg, ...], ReadingSteps]:
    values: dict[str, Array] = {}
    suffixes: dict[str, str] = {}
    for name, column in zip(table.names, table.columns, strict=True):
        parsed = None if name in (POINT, CONFIGURATION) else parse_column(name)
        if parsed is not None and parsed[0].name in _QUANTITIES:
            values[parsed[0].name], suffixes[parsed[0].name] = to_si(numbers(name, column), parsed[1]), parsed[1]
    missing = [column for column in COLUMNS[2:] if column.rpartition("_")[0] not in values]
    if missing:
        raise BadInputError(
            f"missing column{'s' if len(missing) > 1 else ''} {', '.join(missing)} of a points table"
        )
    blank = ~np.all([np.isfinite(values[name]) for name in _QUANTITIES], axis=0)
    if blank.any():
        raise BadInputError(f"row {int(np.argmax(blank)) + 1}: a number is missing; fill it in or remove the leg")
    points = _labels(table.column(POINT))
    configurations = _labels(table.column(CONFIGURATION)) if CONFIGURATION in table.names else [""] * len(points)
    legs = tuple(
        CardLeg(
            row=i + 1,
            point=points[i],
            configuration=configurations[i],
            **{n: float(values[n][i]) for n in _QUANTITIES},
        )
        for i in range(len(points))
    )
    steps = {name: _step(values[name], suffixes[name], getattr(_ROUND_STEPS, name)) for name in _QUANTITIES}
    return legs, ReadingSteps(**steps)


def _labels(column: Column) -> list[str]:
    if column.dtype.kind in "fiu":
        return [f"{value:g}" for value in column]
    return [str(text).strip() for text in texts(column)]


def _step(values: Array, suffix: str, usual: float) -> float:
    """Return the step of the readings; that of a usual display where a short card shows a coarser one or none."""
    found = display_step(values, suffix)
    return found if _FINEST * usual <= found < usual else usual
