"""Read and write Parquet logs, with the TOML header in the metadata of the schema."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from pitotbench.logbook.columns import Column, Table, parse_header, require_few_columns
from pitotbench.logbook.csv import to_columns
from pitotbench.logbook.damage import AGAIN, require_unpackable
from pitotbench.records import BadInputError

_KEY = b"pitotbench"
_TEXT = "BYTE_ARRAY"  # how Parquet stores values of no one width
_NUMBER = np.dtype(np.float64).itemsize  # bytes


def read_parquet(path: Path) -> Table:
    """Read the table of a Parquet file. Raises BadInputError for any other file, and for one that
    is cut off.
    """
    import pyarrow as pa
    from pyarrow import parquet

    try:
        metadata = parquet.read_metadata(path)
        require_few_columns(metadata.num_columns)
        require_unpackable(_numbers_in(metadata), path)
        # Of a text that repeats, a file holds one: so does the memory then.
        leaves = map(metadata.schema.column, range(metadata.num_columns))
        repeated = [leaf.path for leaf in leaves if _is_flat_text(leaf)]
        file = parquet.ParquetFile(path, memory_map=False, read_dictionary=repeated)
        stored = (file.schema_arrow.metadata or {}).get(_KEY, b"")
        names, columns = to_columns(file.read())
    except BadInputError:
        raise
    except (pa.ArrowException, OSError, ValueError) as error:
        raise BadInputError(f"not a complete Parquet file{AGAIN}") from error
    header, warnings = parse_header(stored.decode("utf-8", errors="replace"))
    return Table(names, columns, header, tuple(warnings))


def _numbers_in(metadata: Any) -> float:
    """Return how many numbers of 8 bytes the columns of a file unpack to, by its own metadata: its
    values, each as wide as its type, a text of a list as wide as all that its column holds.
    """
    size = 0
    for group in map(metadata.row_group, range(metadata.num_row_groups)):
        for place in range(group.num_columns):
            chunk, leaf = group.column(place), metadata.schema.column(place)
            bare = leaf.physical_type == _TEXT and not _is_flat_text(leaf)
            width = chunk.total_uncompressed_size if bare else max(_NUMBER, leaf.length or 0)
            size += max(chunk.num_values * width, chunk.total_uncompressed_size)
    return size / _NUMBER


def _is_flat_text(leaf: Any) -> bool:
    """Return whether a column holds a text a row, and no list of them."""
    kind = leaf.logical_type.type
    return leaf.physical_type == _TEXT and not leaf.max_repetition_level and kind != "DECIMAL"


def write_parquet(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write columns with a TOML header."""
    import pyarrow as pa
    from pyarrow import parquet

    table = pa.table({name: pa.array(values) for name, values in columns.items()})
    metadata = {_KEY: tomli_w.dumps(header).encode()}
    parquet.write_table(table.replace_schema_metadata(metadata), path, compression="zstd")
