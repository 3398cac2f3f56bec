"""The table of log formats by file suffix. A new format is one file and one line here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pitotbench.catalog import Catalog
from pitotbench.logbook.csv_format import read_csv, write_csv
from pitotbench.logbook.mat_format import read_mat, write_mat
from pitotbench.logbook.parquet_format import read_parquet, write_parquet
from pitotbench.logbook.table import Column, Table
from pitotbench.logbook.topics import TOPIC_READERS
from pitotbench.records.errors import BadInputError

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


def format_of(path: Path) -> Format:
    """Return the format of a file by its suffix. Raises BadInputError for a suffix that is not in the table."""
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise BadInputError(
            f"a log ends in {', '.join(FORMATS)}, not in {suffix or 'nothing'!r}; rename or convert it "
            f"(read only: {', '.join(TOPIC_READERS)})"
        )
    return FORMATS[suffix]
