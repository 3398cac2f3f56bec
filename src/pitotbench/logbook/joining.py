"""Read a foreign log through its mapping: find files, rename columns, join on one time base."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench.channels import Channel
from pitotbench.logbook.autopilot import as_shown
from pitotbench.logbook.columns import (
    PARAMETERS,
    QUANTITIES,
    SENSOR,
    Column,
    Table,
    almost_numbers,
    clock_seconds,
    is_clock,
    numbered,
    numbers,
    parse_column,
    plain_name,
    within,
)
from pitotbench.logbook.formats import topics_of
from pitotbench.logbook.ground_velocity import components
from pitotbench.logbook.mapping import MappedFile, Mapping, Renamed
from pitotbench.logbook.sensors import chosen
from pitotbench.records import BadInputError
from pitotbench.timeline import nearest
from pitotbench.units import Array, Booleans, from_si, to_si

ReadTable = Callable[[Path], Table]
Parameters = dict[str, float]
FRESH = "gps_fresh"


def read_mapped(
    path: Path,
    mapping: Mapping,
    read_table: ReadTable,
    stated: Parameters | None = None,
    number: int | None = None,
) -> Table:
    """Read the table of a log, from one file or several, with the columns that a mapping names.

    `read_table` reads one file. Of several airspeed sensors the table has that of the `number`,
    counted from 1, the first for None. The pressures of an autopilot are those of the airspeed that
    it showed (`as_shown`), with the parameters of the log, of a table of them in its folder, or
    `stated`. Raises BadInputError for a file or column that is missing or ambiguous.
    """
    topics = topics_of(path)
    files = [] if topics else find_files(path, mapping)
    tables, parameters = topics.read(path, mapping.files) if topics else ([], {})
    for file in files:
        with within(file.name if file else ""):
            tables.append(read_table(file) if file else None)
    if files and files[0]:
        parameters = _parameters_of_table(files[0], mapping.files[0].pattern, read_table)
    found: list[tuple[Table, str]] = []
    sensor, notes = 1, list[str]()
    if len(mapping.files) > 1:
        sensor, base, notes = chosen(_airspeed_sensors(mapping.files, tables), number)
        tables[0] = replace(base, warnings=(*base.warnings, *notes))
    for entry, table in zip(mapping.files, tables, strict=True):
        if table is None or entry.another:  # an optional file that is absent, or another sensor
            continue
        with within(entry.pattern if len(mapping.files) > 1 else "mapping"):
            shown = as_shown(
                next(iter(_sensors(table).values()), table),
                {**parameters, **(stated or {})},
                sensor,
            )
            renamed = rename(shown, entry)
            found.append((renamed if len(mapping.files) == 1 else components(renamed), entry.join))
    joined = found[0][0] if len(found) == 1 else join_tables(found[0][0], found[1:])
    known = {**({PARAMETERS: stated} if stated else {}), **({SENSOR: sensor} if notes else {})}
    return replace(joined, header={**known, **joined.header})


_INSTANCE = "I"  # the field of a DataFlash message that numbers the sensors of one kind


def _sensors(table: Table) -> dict[int, Table]:
    """Return the rows of each sensor of a table of DataFlash messages, by number from 1.

    Any other table is the first, whole.
    """
    if not {"TimeUS", _INSTANCE} <= set(table.names):
        return {1: table}
    instance = numbers(_INSTANCE, table.column(_INSTANCE))
    return {
        int(each) + 1: replace(table, columns=tuple(c[instance == each] for c in table.columns))
        for each in np.unique(instance[np.isfinite(instance)])
    }


def _airspeed_sensors(
    files: Sequence[MappedFile], tables: Sequence[Table | None]
) -> dict[int, tuple[str, Table]]:
    """Return the airspeed sensors of a log in several files, each with its name, by number."""
    found: dict[int, tuple[str, Table]] = {}
    for entry, table in zip(files, tables, strict=True):
        if table is not None and (entry is files[0] or entry.another):
            name, sensors = entry.pattern.removeprefix("*").removesuffix(".csv"), _sensors(table)
            for number, each in sensors.items():
                place = number if entry is files[0] else 1 + max(found, default=0)
                found[place] = (f"{name}[{number - 1}]" if _INSTANCE in table.names else name, each)
    return found


def _parameters_of_table(file: Path, pattern: str, read_table: ReadTable) -> dict[str, Any]:
    """Return the parameters of the table `*PARM.csv` beside a log's first file, by name.

    {} where there is no such table.
    """
    parameter_file = file.with_name(f"{file.name.removesuffix(pattern.rpartition('*')[2])}PARM.csv")
    if not parameter_file.is_file():
        return {}
    with within(parameter_file.name):
        table = read_table(parameter_file)
        return dict(zip(table.column("Name"), numbers("Value", table.column("Value")), strict=True))


def find_files(path: Path, mapping: Mapping) -> list[Path | None]:
    """Return the files of a log, given its folder or first file, None for an optional one missing.

    Raises BadInputError where a needed one is missing.
    """
    if len(mapping.files) == 1 and not path.is_dir():
        return [path]
    first, folder = mapping.files[0].pattern, path if path.is_dir() else path.parent
    lead = path.name if not path.is_dir() else _only_match(folder, first).name
    before, star, after = first.partition("*")
    if not (lead.startswith(before) and lead.endswith(after) and (star or lead == first)):
        raise BadInputError(
            f"the mapping expects the folder of the log or its file {first!r}, not {lead!r}"
        )
    prefix = lead[len(before) : len(lead) - len(after)]
    found: list[Path | None] = []
    for entry in mapping.files:
        files = [folder / pattern.replace("*", prefix) for pattern in entry.patterns]
        found.append(next((file for file in files if file.is_file()), None))
        if found[-1] is None and not entry.optional:
            raise BadInputError(
                f"the mapping needs {' or '.join(repr(file.name) for file in files)} in the folder "
                f"of {lead!r}, and it is not there: give the recorder's own file (.ulg, .bin), or "
                "write all of its topics into that folder"
            )
    return found


def _only_match(folder: Path, pattern: str) -> Path:
    found = sorted(folder.glob(pattern))
    if len(found) == 1:
        return found[0]
    names = ", ".join(file.name for file in found)
    raise BadInputError(
        f"the folder holds several files {pattern!r} ({names}); name one of them"
        if found
        else f"the folder holds no file {pattern!r}: give the folder or the first file of the log"
    )


def rename(table: Table, entry: MappedFile) -> Table:
    """Return the mapped columns under our names, of several for one quantity the first present.

    A missing column gives a warning where it is neither essential nor optional. Raises
    BadInputError where an essential column is missing or the mapping names an unknown quantity.
    """
    quantities: dict[Renamed, tuple[Channel, int]] = {}
    for target in entry.columns:
        plain, sensor = numbered(target.name)
        bare = QUANTITIES.get(plain)  # without a unit: its values tell it (`fill_units`)
        parsed = (bare, "") if bare else parse_column(plain)
        if parsed is None:
            raise BadInputError(
                f"the mapping names {target.name!r}, which is no column of a flight log: "
                "`pitotbench map LOG` writes those that are"
            )
        quantities[target] = parsed[0], sensor
    table = first_of_each(table)
    here = {plain_name(n): n for n in reversed(table.names)} | {n: n for n in table.names}
    present = {quantities[target] for target in entry.columns if plain_name(target.theirs) in here}
    found: dict[tuple[Channel, int], tuple[str, Column]] = {}
    lost, words = [], []
    for target, quantity in quantities.items():
        theirs = here.get(target.theirs, here.get(plain_name(target.theirs), target.theirs))
        if theirs not in table.names and (
            target.optional or quantity in present or not quantity[0].essential
        ):
            if not target.optional and quantity not in present:
                lost.append(target.theirs)
            continue
        column = table.column(theirs)
        if quantity in found:
            continue
        values = almost_numbers(column) if column.dtype.kind == "O" else None
        if values is not None and quantity[0].kind == "number":
            words.append(theirs)
            column = values
        if target.factor != 1.0 or target.offset != 0.0:
            column = numbers(target.theirs, column) * target.factor + target.offset
        found[quantity] = (target.name, column)
    warnings = (
        *table.warnings,
        *(f"the mapping's column {name!r} is not in the file" for name in lost),
        *(f"column {name!r} holds words among its numbers: they count as blank" for name in words),
    )
    names, columns = zip(*found.values(), strict=True) if found else ((), ())
    return replace(table, names=names, columns=columns, warnings=warnings, units=())


def first_of_each(table: Table) -> Table:
    """Return a table with the first of the columns that have one name, and a remark about it."""
    places: dict[str, int] = {}
    for place, name in enumerate(table.names):
        places.setdefault(name, place)
    if len(places) == len(table.names):
        return table
    twice = [name for name in places if name and table.names.count(name) > 1]
    note = f"columns given more than once: {', '.join(twice)}: the first of each is read"
    return replace(
        table,
        names=tuple(places),
        columns=tuple(table.columns[place] for place in places.values()),
        units=tuple(table.units[place] for place in places.values()) if table.units else (),
        warnings=(*table.warnings, *([note] if twice else [])),
    )


def join_tables(base: Table, others: list[tuple[Table, str]]) -> Table:
    """Bring other tables to the times of the base. Rows that some table does not cover are dropped.

    The fixes of a receiver are held from the row of one to that of the next, and `gps_fresh` marks
    these rows, as in a log of one table: a velocity interpolated to each row would count as a fix
    each. Raises BadInputError where the tables do not overlap in time.
    """
    time = _time(base)
    clocks = [_time(table) for table, _ in others]
    # Only the time that all tables cover: beyond it, interpolation would repeat the last value.
    start = max([time[0], *(clock[0] for clock in clocks)])
    end = min([time[-1], *(clock[-1] for clock in clocks)])
    inside = (time >= start) & (time <= end)
    if not inside.any():
        raise BadInputError(
            "the parts of the log do not overlap in time: take those of one flight, or correct the "
            "time columns of the mapping"
        )
    names, columns = list(base.names), [column[inside] for column in base.columns]
    warnings = list(base.warnings)
    for (table, join), clock in zip(others, clocks, strict=True):
        warnings += table.warnings
        rows = np.arange(int(inside.sum()))
        if (
            join == "linear"
            and any(name.startswith("velocity_north_") for name in table.names)
            and FRESH not in names
        ):
            fresh, rows = _fixes(time[inside], clock)
            names.append(FRESH)
            columns.append(fresh)
        for name, column in zip(table.names, table.columns, strict=True):
            # The clock of another file has served; the joined table has the clock of the base.
            if not name.startswith("time_"):
                names.append(name)
                columns.append(_at(time[inside], clock, name, column, join)[rows])
    header = {key: value for table, _ in others for key, value in table.header.items()}
    return Table(tuple(names), tuple(columns), {**header, **base.header}, tuple(warnings))


def _fixes(time: Array, clock: Array) -> tuple[Booleans, NDArray[np.intp]]:
    """Return which rows at `time`, (n,), hold a fix, and the last such row for each row, (n,).

    The row nearest to a fix of the receiver at `clock` holds it.
    """
    rows, fresh = np.arange(len(time)), np.zeros(len(time), dtype=np.bool_)
    fresh[nearest(clock, time)] = True
    fresh[0] = True  # which the first fix precedes
    return fresh, np.maximum.accumulate(np.where(fresh, rows, 0))


def _time(table: Table) -> Array:
    """Return the time column in seconds.

    Raises BadInputError unless it increases, as interpolation needs.
    """
    name = next(
        (n for n in table.names if n in {f"time_{s}" for s in QUANTITIES["time"].suffixes}), None
    )
    if name is None:
        raise BadInputError("each file of a mapping needs a time column: add a line for it")
    column = table.column(name)
    time = (
        clock_seconds(name, column)
        if is_clock(column)
        else to_si(numbers(name, column), name.removeprefix("time_"))
    )
    if len(time) < 2 or not np.all(np.diff(time) > 0.0):
        back = int(np.argmin(np.diff(time) > 0.0)) + 2 if len(time) > 1 else 1
        raise BadInputError(
            f"column {name!r}, row {back}: time must increase in every part of the log; remove the "
            "rows that repeat or run back, in its tables as CSV"
        )
    return time


def _at(time: Array, clock: Array, name: str, column: Column, join: str) -> Column:
    """Return a column, sampled at `clock`, at other times, by the way of its join.

    Either interpolated, or the last or the nearest value.
    """
    if join == "linear" and column.dtype.kind == "f":
        parsed = parse_column(name)
        if parsed is not None and parsed[0].wraps:  # between 359° and 1° lies 0°, not 180°
            turned = np.unwrap(to_si(column, parsed[1]))
            return from_si(np.interp(time, clock, turned) % (2.0 * np.pi), parsed[1])
        return np.interp(time, clock, numbers(name, column))
    if join == "nearest":
        return column[nearest(time, clock)]
    return column[np.maximum(np.searchsorted(clock, time, side="right") - 1, 0)]
