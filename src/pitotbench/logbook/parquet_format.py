"""Read and write Parquet logs, with the TOML header in the metadata of the schema."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w

from pitotbench.logbook.csv_format import to_column
from pitotbench.logbook.header import parse_header
from pitotbench.logbook.table import Column, Table
from pitotbench.records.errors import BadInputError

_KEY = b"pitotbench"


def read_parquet(path: Path) -> Table:
    """Read the table of a Parquet file. Raises BadInputError for any other file, and for one that is cut off."""
    import pyarrow as pa
    from pyarrow import parquet

    try:
        found = parquet.ParquetFile(path, memory_map=False).read()
        names = tuple(found.column_names)
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError, OSError, UnicodeDecodeError) as error:
        raise BadInputError(f"not a complete Parquet file: {str(error).splitlines()[0]}") from error
    stored = (found.schema.metadata or {}).get(_KEY, b"")
    header, warnings = parse_header(stored.decode("utf-8", errors="replace"))
    return Table(names, tuple(to_column(column) for column in found.columns), header, tuple(warnings))


def write_parquet(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write columns with a TOML header."""
    import pyarrow as pa
    from pyarrow import parquet

    table = pa.table({name: pa.array(values) for name, values in columns.items()})
    metadata = {_KEY: tomli_w.dumps(header).encode()}
    parquet.write_table(table.replace_schema_metadata(metadata), path, compression="zstd")
