"""Read and write Parquet logs, with the TOML header in the metadata of the schema."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tomli_w

from pitotbench.logbook.columns import Column, Table, parse_header, require_few_columns
from pitotbench.logbook.csv import to_columns
from pitotbench.logbook.damage import NUMBER, complete, require_unpackable

if TYPE_CHECKING:
    import pyarrow as pa

_KEY = b"pitotbench"
_TEXT = "BYTE_ARRAY"  # how Parquet stores values of no one width
_WIDEST = 16  # bytes of a decimal number


def read_parquet(path: Path) -> Table:
    """Read the table of a Parquet file.

    Raises BadInputError for any other file, and for one that is cut off.
    """
    import pyarrow as pa
    from pyarrow import parquet

    with complete("Parquet file", (pa.ArrowException, OSError, ValueError)):
        metadata = parquet.read_metadata(path)
        require_few_columns(metadata.num_columns)
        groups = map(metadata.row_group, range(metadata.num_row_groups))
        unpacked = max(
            metadata.num_rows * metadata.num_columns,
            sum(g.total_byte_size for g in groups) / NUMBER,
        )
        require_unpackable(unpacked, path)
        leaves = [*map(metadata.schema.column, range(metadata.num_columns))]
        # Of a text that repeats, a file holds one: so does the memory then.
        repeated = [leaf.path for leaf in leaves if _is_flat_text(leaf)]
        file = parquet.ParquetFile(path, memory_map=False, read_dictionary=repeated)
        # Several values a row, or one of many bytes.
        wide = {
            leaf.path.partition(".")[0]
            for leaf in leaves
            if leaf.max_repetition_level > 0 or (leaf.length or 0) > _WIDEST
        }
        stored = (file.schema_arrow.metadata or {}).get(_KEY, b"")
        names, columns = to_columns(_table(file, wide, path))
    header, warnings = parse_header(stored.decode("utf-8", errors="replace"))
    left_out = [f"column {name!r} holds lists: it is left out" for name in sorted(wide)]
    return Table(names, columns, header, (*warnings, *left_out))


def _table(file: Any, wide: set[str], path: Path) -> "pa.Table":
    """Return the table of a file without its wide columns, read part by part.

    Reading ends where it grows larger than it may be: a file's own table of contents may tell less
    than it unpacks to.
    """
    import pyarrow as pa

    kept = pa.schema([field for field in file.schema_arrow if field.name not in wide])
    batches, values, texts = list[Any](), 0, dict[int, int]()
    for batch in file.iter_batches(columns=kept.names):
        batches.append(batch)
        values += batch.num_rows * batch.num_columns
        dictionaries = [c.dictionary for c in batch.columns if pa.types.is_dictionary(c.type)]
        # The parts of a column share its texts.
        texts |= {
            part.address: part.size for each in dictionaries for part in each.buffers() if part
        }
        require_unpackable(values + sum(texts.values()) / NUMBER, path)
    return pa.Table.from_batches(batches, batches[0].schema if batches else kept)


def _is_flat_text(leaf: Any) -> bool:
    """Return whether a column holds a text a row, and no list of them."""
    return (
        leaf.physical_type == _TEXT
        and not leaf.max_repetition_level
        and leaf.logical_type.type != "DECIMAL"
    )


def write_parquet(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write columns with a TOML header."""
    import pyarrow as pa
    from pyarrow import parquet

    table = pa.table({name: pa.array(values) for name, values in columns.items()})
    metadata = {_KEY: tomli_w.dumps(header).encode()}
    parquet.write_table(table.replace_schema_metadata(metadata), path, compression="zstd")
