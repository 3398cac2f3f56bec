"""The tables of log formats by file suffix: tables, logs that hold topics; and the writer.

A new format is one file and one line here.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pitotbench.catalog import Catalog
from pitotbench.logbook.columns import QUANTITIES, Column, Table, atomic, within
from pitotbench.logbook.csv import read_csv, write_csv
from pitotbench.logbook.dataflash import is_dataflash, read_messages
from pitotbench.logbook.mapping import MappedFile
from pitotbench.logbook.matlab import read_mat, write_mat
from pitotbench.logbook.other_kinds import NOT_READ
from pitotbench.logbook.parquet import read_parquet, write_parquet
from pitotbench.logbook.recorder_files import read_igc
from pitotbench.logbook.spreadsheet import read_xlsx
from pitotbench.logbook.ulog import read_topics
from pitotbench.records import BadInputError
from pitotbench.records.intake import require_regular
from pitotbench.records.log import FlightLog

Write = Callable[[Path, Mapping[str, Column], Mapping[str, Any]], None]


@dataclass(frozen=True, slots=True)
class Format:
    """The functions that read and write the files of one suffix."""

    read: Callable[[Path], Table]
    write: Write


FORMATS: Catalog[Format] = Catalog(
    "log format",
    {
        ".csv": Format(read_csv, write_csv),
        ".parquet": Format(read_parquet, write_parquet),
        ".mat": Format(read_mat, write_mat),
    },
)


# Files that are read and never written.
READ_ONLY: dict[str, Callable[[Path], Table]] = {
    ".txt": read_csv,
    ".tsv": read_csv,
    ".log": read_csv,
    ".csv.gz": read_csv,
    ".ict": read_csv,
    ".igc": read_igc,
    ".igc.gz": read_igc,
    ".xlsx": read_xlsx,
}


def reader_of(path: Path) -> Callable[[Path], Table]:
    """Return the reader of a file by its suffix.

    Raises BadInputError for a suffix that is not in the tables.
    """
    packed = next((suffix for suffix in READ_ONLY if path.name.lower().endswith(suffix)), None)
    if packed is not None:
        return READ_ONLY[packed]
    for suffix in ("".join(path.suffixes[-2:]), path.suffix):
        if (words := NOT_READ.get(suffix.lower())) is not None:
            raise BadInputError(words)
    return format_of(path).read


def format_of(path: Path) -> Format:
    """Return the format of a file by its suffix.

    Raises BadInputError for a suffix that is not in the table.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise BadInputError(
            f"a log ends in {', '.join(FORMATS)}, not in {suffix or 'nothing'!r}: write it as one "
            "of these with the program that made it (read only: "
            f"{', '.join(dict.fromkeys([*READ_ONLY, *TOPIC_READERS]))})"
        )
    return FORMATS[suffix]


def write_log(log: FlightLog, path: Path | str) -> Path:
    """Write a log with canonical columns, in the format of the path's suffix, and return the path.

    An error leaves no incomplete file. Raises BadInputError for an unknown suffix or an unwritable
    place.
    """
    target = Path(path)
    with within(target):
        kind = format_of(target)
    columns = {QUANTITIES[name].column: values for name, values in log.channels().items()}
    with atomic(target) as temporary:
        kind.write(temporary, columns, log.header)
    return target


# The tables of the wanted topics by name, and the parameters of the autopilot by name.
Topics = tuple[dict[str, Table], dict[str, Any]]
ReadTopics = Callable[[Path, Sequence[str]], Topics]


@dataclass(frozen=True, slots=True)
class TopicReader:
    """How the files of one suffix are read, and the shipped mapping that suits them.

    `read_named` returns those of the wanted topics that are there.
    """

    kind: str
    mapping: str
    read_named: ReadTopics

    def read(
        self, path: Path, files: Sequence[MappedFile]
    ) -> tuple[list[Table | None], dict[str, Any]]:
        """Return the tables of a mapping's files, None for absent ones, and the log's parameters.

        Only an optional file may be absent. Raises BadInputError for a missing topic, with those
        that are there.
        """
        wanted = [
            [pattern.removeprefix("*").removesuffix(".csv") for pattern in entry.patterns]
            for entry in files
        ]
        require_regular(path)
        found, parameters = self.read_named(path, [name for names in wanted for name in names])
        missing = [
            " or ".join(names)
            for names, entry in zip(wanted, files, strict=True)
            if not entry.optional and not found.keys() & set(names)
        ]
        if missing:
            known = ", ".join(sorted(found)) or "none of those wanted"
            raise BadInputError(
                f"the {self.kind} holds no topic {', '.join(missing)}; it holds {known}: set the "
                "autopilot to log the airspeed sensor, the barometer and the GPS, and fly again"
            )
        tables = [next((found[name] for name in names if name in found), None) for names in wanted]
        return tables, parameters


TOPIC_READERS = {
    ".ulg": TopicReader("ULog", "px4", read_topics),
    ".bin": TopicReader("DataFlash log", "ardupilot", read_messages),
    ".log": TopicReader("DataFlash log", "ardupilot", read_messages),
}


def topics_of(path: Path) -> TopicReader | None:
    """Return the reader of a log that holds topics; None for another, as a .log that is a table."""
    suffix = path.suffix.lower()
    if suffix == ".log" and path.is_file() and not is_dataflash(path):
        return None
    return TOPIC_READERS.get(suffix)
