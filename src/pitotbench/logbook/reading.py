"""Read a file as a FlightLog: recognize its columns, convert them to SI, check them."""

from collections import abc
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pitotbench.catalog import explain
from pitotbench.logbook.assembly import WHOLE, Part, log_of
from pitotbench.logbook.bundle import is_bundle, logs_in, opened
from pitotbench.logbook.columns import (
    CALIBRATE,
    KIND,
    MAPPING,
    PARAMETERS,
    QUANTITIES,
    Table,
    split_positions,
    within,
)
from pitotbench.logbook.draft import MissingColumnsError, has_our_names
from pitotbench.logbook.formats import reader_of, topics_of
from pitotbench.logbook.joining import Parameters, read_mapped, rename
from pitotbench.logbook.mapping import Mapping, find_mapping, recognized
from pitotbench.logbook.sensors import of_sensor
from pitotbench.records import BadInputError
from pitotbench.records.calibration_request import FACTS
from pitotbench.records.intake import require_regular
from pitotbench.records.log import FORMAT, UNITS_BY, FlightLog

if TYPE_CHECKING:
    from pitotbench.logbook.drafting import DraftedMapping


class UnusableRecorderError(BadInputError):
    """The recorder is known, and what it records cannot be calibrated."""


def read_log(
    path: Path | str,
    mapping: Path | str | None = None,
    parameters: abc.Mapping[str, float] | None = None,
    part: Part = WHOLE,
    airspeed_sensor: int | None = None,
    **facts: str | None,
) -> FlightLog:
    """Read a flight log from a file, a folder or a .zip file that holds one.

    A file in a .zip is `card.zip/flight.csv`.

    `mapping` names a shipped mapping or a TOML file, for logs with other column names. Without it,
    a log of a format that a shipped mapping recognizes is read by that mapping, whose name is then
    `log.header["mapping"]`. `parameters` are the airspeed parameters of an autopilot with which the
    log was flown, by name, in place of those that it holds. Of several airspeed sensors that of the
    number `airspeed_sensor` is read, counted from 1; the first for None. Only the `part` is read
    and judged: from so many seconds after the first row to so many, None for an end of the log.
    `facts` state what the log does not hold: `temperature_c` the temperature of the day [°C], such
    as `18±2@ground` (`temperature.stated_day`), `height` that above the sea, such as `2000±300ft`
    (`stated_height`). The entry `warnings` of `log.header` lists, with row numbers, what was
    dropped and what looks wrong.

    Raises BadInputError for a log that cannot be used (the message begins with the file) and for an
    unknown fact, UnknownNameError for a mapping that is not shipped.
    """
    source = Path(path)
    with within(source):
        stated = dict(parameters or {})
        table, drafted = _table_and_draft(source, mapping, stated, airspeed_sensor, facts)
        try:
            return log_of(table, part)
        except MissingColumnsError as error:
            if mapping is not None:
                raise
            raise MissingColumnsError(_named(source, table, drafted, error)) from error


def _named(
    source: Path, table: Table, drafted: "DraftedMapping | None", error: BadInputError
) -> str:
    """Return what a file is that lacks the columns of a log, and the way on."""
    from pitotbench.logbook.recognition import kind_of, what_it_lacks  # a log does without

    with opened(source) as place:
        file = _only_log(place, source) if is_bundle(place) else place
        if kind := kind_of(file, source):
            return kind
        with suppress(BadInputError):  # of a log in topics the table that was joined
            table = table if drafted else read_table(file)
        return what_it_lacks(table, drafted, source, error)


def whole_table(
    source: Path,
    mapping: Path | str | None = None,
    parameters: Parameters | None = None,
    airspeed_sensor: int | None = None,
    facts: abc.Mapping[str, str | None] | None = None,
) -> Table:
    """Return the table of a log under our column names, before it is checked.

    Parameters and errors as of `read_log`, without the file in the message.
    """
    return _table_and_draft(source, mapping, parameters or {}, airspeed_sensor, facts or {})[0]


def _table_and_draft(
    source: Path,
    mapping: Path | str | None,
    parameters: Parameters,
    airspeed_sensor: int | None,
    facts: abc.Mapping[str, str | None],
) -> tuple[Table, "DraftedMapping | None"]:
    """Return the table, and the draft of its columns where one was made: it takes seconds."""
    named = None if mapping is None else find_mapping(mapping)
    with opened(source) as place:
        table = (
            table_of(
                _only_log(place, source) if is_bundle(place) else place, parameters, airspeed_sensor
            )
            if named is None
            else _advised(read_mapped(place, named, read_table, parameters, airspeed_sensor), named)
        )
        table = with_facts(of_sensor(table, airspeed_sensor), facts)
    return _by_names(table) if named is None and MAPPING not in table.header else (table, None)


def with_facts(table: Table, facts: abc.Mapping[str, str | None]) -> Table:
    """Return a table with what is stated of the flight in its header.

    Raises BadInputError for an unknown name.
    """
    for name in facts:
        if name not in FACTS:
            raise BadInputError(explain("fact of a flight", name, list(FACTS)))
    return replace(table, header={**table.header, **{k: v for k, v in facts.items() if v}})


def _only_log(folder: Path, source: Path) -> Path:
    """Return the file of the only log of a folder, which the user named as `source`.

    Raises BadInputError, with the way to the flights, where there are others.
    """
    files = logs_in(folder)
    if len(files) == 1:
        return files[0]
    first = source / (files[0].relative_to(folder) if files else "flight.csv")
    raise BadInputError(
        f"a folder of {len(files) or 'no'} logs; name one, such as {first}: `pitotbench inspect "
        f"{source}` lists the flights of several"
    )


def table_of(
    path: Path, stated: Parameters | None = None, airspeed_sensor: int | None = None
) -> Table:
    """Return the table of a file under our column names as far as they are known.

    The user's own mapping has no part in it. The `stated` parameters of an autopilot replace those
    in the header; of a log in several files the table has the `airspeed_sensor`. Raises
    BadInputError for a file that cannot be read.
    """
    topics = topics_of(path)
    if topics is None:
        table = read_table(path)
        if stated:
            table = replace(table, header={**table.header, PARAMETERS: stated})
        found = recognized(table.names)
        several = () if found is None else find_mapping(found).files[1:]
        if found is None or (several and not path.match(find_mapping(found).files[0].pattern)):
            return _filled(table)  # of a log in several files, only the first leads to the others
        name, known = found, find_mapping(found)
    else:
        name, known = topics.mapping, find_mapping(topics.mapping)
    if known.refuse:
        raise UnusableRecorderError(f"{known.title}: {known.refuse}")
    if topics is None and len(known.files) == 1:
        table = mapped(table, name)
    else:
        table = _advised(read_mapped(path, known, read_table, stated, airspeed_sensor), known)
    note = f"recognized as {known.title}: read by the mapping {name}"
    return replace(table, header={**table.header, MAPPING: name}, warnings=(note, *table.warnings))


def mapped(table: Table, mapping: Path | str) -> Table:
    """Return a table under our column names by a mapping of one file. Raises as `read_log` does."""
    named = find_mapping(mapping)
    return _advised(_filled(rename(table, named.files[0])), named)


def _by_names(table: Table) -> tuple[Table, "DraftedMapping | None"]:
    """Return a table read by the draft of its columns, if that is sure, and the draft.

    Only a table whose recorder no mapping knows and whose names are not ours is drafted; any other
    stays as it is.
    """
    if has_our_names(table):
        return table, None
    from pitotbench.logbook.drafting import draft_mapping, read_by_draft  # ours do without

    drafted = None
    with suppress(BadInputError):  # of which the missing columns are told
        drafted = draft_mapping(table)
        return read_by_draft(table, drafted) or table, drafted
    return table, drafted


def _filled(table: Table) -> Table:
    """The table with the units of columns that bear a name of ours without one, by their values."""
    if any(name in QUANTITIES and QUANTITIES[name].unit for name in table.names):
        from pitotbench.logbook.unit_trials import fill_units  # a log of ours does without

        return fill_units(table)
    return table


def _advised(table: Table, mapping: Mapping) -> Table:
    """Return the table with its mapping's choices, kind of aircraft, and whether units are fixed.

    A recorder's format fixes them.
    """
    advice: dict[str, object] = {CALIBRATE: dict(mapping.calibrate)} if mapping.calibrate else {}
    advice |= {KIND: mapping.kind} if mapping.kind else {}
    advice |= {UNITS_BY: FORMAT} if mapping.shipped else {}
    return replace(table, header={**table.header, **advice})


def needs_mapping(path: Path) -> str:
    """Return why a file needs no mapping: a shipped one knows it, or its columns are ours.

    "" where the file needs one. Raises BadInputError for a file that cannot be read, and
    UnusableRecorderError.
    """
    try:
        table = table_of(path)
        log_of(table)
        if MAPPING in table.header:
            return table.warnings[0]
    except UnusableRecorderError:
        raise
    except BadInputError:  # what is wrong shows in the draft
        return ""
    return "its columns are those of a flight log; no mapping is needed"


def read_table(path: Path) -> Table:
    """Return the table of a file as it is.

    Raises BadInputError for a file that cannot be read or holds no row.
    """
    read = reader_of(path)
    require_regular(path)
    try:
        empty = path.stat().st_size == 0
    except OSError as error:
        raise BadInputError(
            f"cannot be read: {error.strerror or error}; check its name and who may read it"
        ) from error
    if empty:
        raise BadInputError("the file is empty: copy it again from its source")
    table = read(path)
    if len(table) == 0:
        raise BadInputError("the log has column names but no rows: copy it again from its source")
    # A mapping that the file names was not applied by this reading.
    return replace(
        split_positions(table),
        header={name: value for name, value in table.header.items() if name != MAPPING},
    )
