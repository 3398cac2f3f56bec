"""The table of log formats by file suffix, and the writer."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pitotbench.catalog import Catalog
from pitotbench.logbook.columns import QUANTITIES, Column, Table, atomic, within
from pitotbench.logbook.csv import read_csv, write_csv
from pitotbench.logbook.matlab import read_mat, write_mat
from pitotbench.logbook.parquet import read_parquet, write_parquet
from pitotbench.logbook.recorder_files import read_igc
from pitotbench.logbook.topics import TOPIC_READERS
from pitotbench.records import BadInputError
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
}


def reader_of(path: Path) -> Callable[[Path], Table]:
    """Return the reader of a file by its suffix. Raises BadInputError for a suffix that is not in
    the tables.
    """
    packed = next((suffix for suffix in READ_ONLY if path.name.lower().endswith(suffix)), None)
    return format_of(path).read if packed is None else READ_ONLY[packed]


def format_of(path: Path) -> Format:
    """Return the format of a file by its suffix. Raises BadInputError for a suffix that is not in
    the table.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise BadInputError(
            f"a log ends in {', '.join(FORMATS)}, not in {suffix or 'nothing'!r}; rename or "
            "convert it "
            f"(read only: {', '.join(dict.fromkeys([*READ_ONLY, *TOPIC_READERS]))})"
        )
    return FORMATS[suffix]


# Write a FlightLog to a file.


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
