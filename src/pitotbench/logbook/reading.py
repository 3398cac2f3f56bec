"""Read a file as a FlightLog: recognize its columns, convert them to SI, check them."""

from collections import abc
from dataclasses import replace
from pathlib import Path

from pitotbench.logbook.checks import CHECKS, CLOCK_CHECKS
from pitotbench.logbook.columns import (
    CALIBRATE,
    MAPPING,
    PARAMETERS,
    WARNINGS,
    Table,
    earlier_warnings,
    require_regular,
)
from pitotbench.logbook.derived import derive
from pitotbench.logbook.draft import MissingColumnsError, draft_of, require
from pitotbench.logbook.formats import TOPIC_READERS, reader_of
from pitotbench.logbook.joining import Parameters, read_mapped, rename
from pitotbench.logbook.mapping import Mapping, find_mapping, recognized
from pitotbench.records import BadInputError
from pitotbench.records.log import START as FIRST_ROW
from pitotbench.records.log import FlightLog

Part = tuple[float | None, float | None]  # s after the first row, from and to
WHOLE: Part = (None, None)


def read_log(
    path: Path | str,
    mapping: Path | str | None = None,
    parameters: abc.Mapping[str, float] | None = None,
    part: Part = WHOLE,
) -> FlightLog:
    """Read a flight log from a file.

    `mapping` names a shipped mapping or a TOML file, for logs with other column names. Without it,
    a log of a format that a shipped mapping recognizes is read by that mapping, whose name is then
    `log.header["mapping"]`. `parameters` are the airspeed parameters of an autopilot with which the
    log was flown, by name, in place of those that it holds. Only the `part` is read and judged:
    from so many seconds after the first row to so many, None for an end of the log. The entry
    `warnings` of `log.header` lists, with row numbers, what was dropped and what looks wrong.

    Raises BadInputError for a log that cannot be used (the message begins with the file),
    UnknownNameError for a mapping that is not shipped.
    """
    source = Path(path)
    named = None if mapping is None else find_mapping(mapping)
    try:
        stated = dict(parameters or {})
        return log_of(
            table_of(source, stated)
            if named is None
            else _advised(read_mapped(source, named, read_table, stated), named),
            part,
        )
    except BadInputError as error:
        raise type(error)(f"{source}: {error}") from error


def table_of(path: Path, stated: Parameters | None = None) -> Table:
    """Return the table of a file under our column names as far as they are known, without a mapping
    by the user.

    The `stated` parameters of an autopilot replace those in the header. Raises BadInputError for a
    file that cannot be read.
    """
    if path.suffix.lower() in TOPIC_READERS:
        name = TOPIC_READERS[path.suffix.lower()].mapping
        known = find_mapping(name)
        table = _advised(read_mapped(path, known, read_table, stated), known)
    else:
        table = read_table(path)
        if stated:
            table = replace(table, header={**table.header, PARAMETERS: stated})
        found = recognized(table.names)
        if found is None:
            return table
        name, table = found, mapped(table, found)
    title = find_mapping(name).title
    note = f"recognized as {title}: read by the mapping {name}"
    return replace(table, header={**table.header, MAPPING: name}, warnings=(note, *table.warnings))


def mapped(table: Table, mapping: Path | str) -> Table:
    """Return a table under our column names by a mapping of one file. Raises as `read_log` does."""
    named = find_mapping(mapping)
    return _advised(rename(table, named.files[0]), named)


def _advised(table: Table, mapping: Mapping) -> Table:
    """The table with the choices of its mapping for a calibration, which go with the log."""
    advice = {CALIBRATE: dict(mapping.calibrate)} if mapping.calibrate else {}
    return replace(table, header={**table.header, **advice})


def needs_mapping(path: Path) -> str:
    """Return why a file needs no mapping: its columns are ours, or a shipped mapping knows it.
    Empty where it does.

    Raises BadInputError for a file that cannot be read.
    """
    table = table_of(path)
    if MAPPING in table.header:
        return table.warnings[0]
    draft = draft_of(table)
    derive(draft, {})
    try:
        require(draft)
    except MissingColumnsError:
        return ""
    return "its columns are those of a flight log; no mapping is needed"


def log_of(table: Table, part: Part = WHOLE) -> FlightLog:
    """Return the checked log of a table, or of its `part`, as in `read_log`. Raises BadInputError
    where it cannot be used.
    """
    draft, header = draft_of(table), dict(table.header)
    derive(draft, header)
    require(draft)
    del table  # or its columns would stay in memory beside those of which a check drops rows
    for check in CLOCK_CHECKS:
        check(draft)
    if part != WHOLE:
        draft.keep_part(*part)
        header[FIRST_ROW] = draft.start
    for check in CHECKS:
        check(draft)
    warnings = [*earlier_warnings(header), *draft.warnings]
    header.pop(WARNINGS, None)
    if warnings:
        # Each once: a log written and read again repeats them. The last of equal texts has the
        # finding beside it.
        header[WARNINGS] = list({text: text for text in warnings}.values())
    return FlightLog(**draft.channels, header=header)


def read_table(path: Path) -> Table:
    """Return the table of a file as it is. Raises BadInputError for a file that cannot be read or
    holds no row.
    """
    if path.is_dir():
        raise BadInputError(
            "a folder, not a log; name its file, or give the mapping of a log in several files"
        )
    read = reader_of(path)
    require_regular(path)
    try:
        empty = path.stat().st_size == 0
    except OSError as error:
        raise BadInputError(f"cannot be read: {error.strerror or error}") from error
    if empty:
        raise BadInputError("the file is empty")
    table = read(path)
    if len(table) == 0:
        raise BadInputError("the log has column names but no rows")
    # A mapping that the file names was not applied by this reading.
    return replace(
        table, header={name: value for name, value in table.header.items() if name != MAPPING}
    )
