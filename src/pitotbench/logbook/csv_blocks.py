"""A plain CSV table, block by block into arrays: what is in memory is the columns and a few blocks of the file.

A column's type is that of its first block. Whole numbers and empty columns count as floats. Where a later block
does not fit, or a column holds anything but numbers, true and false, or text, the table is not plain: the caller
reads the file as a whole, which takes more memory and can name the row.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pitotbench.logbook.table import Column
from pitotbench.units import Booleans

if TYPE_CHECKING:
    import pyarrow as pa
    from pyarrow import csv

BLOCK = 1 << 20  # bytes of the file that are parsed at a time
_SPARE = 1.1  # times the rows that are expected from the first block and the size of the file

Types = dict[str, "pa.DataType"]


class _NotPlainError(Exception):
    """The table has to be read as a whole."""


def read_blocks(
    open_reader: "Callable[[Types | None], csv.CSVStreamingReader]", size: int
) -> dict[str, Column] | None:
    """The columns by name, in file order; None for a table that is not plain.

    `open_reader` opens the file with column types, or with None to have them inferred; `size` is that of the table
    [bytes]. An empty cell is NaN among numbers, None among texts.
    """
    import pyarrow as pa

    columns: dict[str, _Growing] = {}
    try:
        types = _plain_types(open_reader(None).schema)
        for block in open_reader(types):
            if not block.num_rows:
                continue
            expected = int(_SPARE * block.num_rows * max(1.0, size / BLOCK))
            for name, values in zip(block.schema.names, block.columns, strict=True):
                columns.setdefault(name, _Growing(types[name], expected)).append(values)
    except (pa.ArrowInvalid, UnicodeDecodeError, _NotPlainError):
        return None
    return {name: column.whole() for name, column in columns.items()} or None


def _plain_types(schema: "pa.Schema") -> Types:
    if len(set(schema.names)) < len(schema.names):
        raise _NotPlainError
    return {field.name: _plain_type(field.type) for field in schema}


def _plain_type(kind: "pa.DataType") -> "pa.DataType":
    import pyarrow as pa

    if pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_null(kind):
        return pa.float64()
    if pa.types.is_string(kind):
        return pa.dictionary(pa.int32(), pa.string())
    if pa.types.is_boolean(kind):
        return kind
    raise _NotPlainError


class _Growing:
    """A column to which blocks are appended. Of texts, each different one is kept once."""

    def __init__(self, kind: "pa.DataType", rows: int) -> None:
        import pyarrow as pa

        flags, numbers = pa.types.is_boolean(kind), pa.types.is_floating(kind)
        self._texts: dict[str | None, int] | None = None if flags or numbers else {}
        self._values: NDArray[np.generic] = np.empty(
            rows, np.bool_ if flags else np.float64 if numbers else np.intp
        )
        self._rows = 0

    def append(self, block: "pa.Array") -> None:
        """Copy a block behind the others. Raises _NotPlainError for a flag that is empty."""
        first, self._rows = self._rows, self._rows + len(block)
        if self._rows > len(self._values):
            self._values.resize(2 * self._rows, refcheck=False)
        space = self._values[first : self._rows]
        if self._texts is not None:
            space[:] = _numbered(block, self._texts)
        elif space.dtype == np.bool_:
            if block.null_count:
                raise _NotPlainError
            space[:] = _bits(block, 1)
        else:  # plus zero: a minus zero would turn the direction of a velocity by half a circle
            np.add(_values(block, np.float64), 0.0, out=space)
            if block.null_count:
                space[~_bits(block, 0)] = np.nan

    def whole(self) -> Column:
        """The column, with memory of its own and none to spare."""
        self._values.resize(self._rows, refcheck=False)
        return self._values if self._texts is None else np.array(list(self._texts), dtype=object)[self._values]


def _numbered(block: "pa.DictionaryArray", texts: dict[str | None, int]) -> NDArray[np.intp]:
    """The numbers of a block's texts; a new text gets a number."""
    codes = _values(block.indices, np.int32)
    if block.null_count:
        codes = np.where(_bits(block.indices, 0), codes, -1)
    different = [*block.dictionary.to_pylist(), *([None] if block.null_count else [])]
    numbers: NDArray[np.intp] = np.array([texts.setdefault(text, len(texts)) for text in different], dtype=np.intp)
    return numbers.take(codes)


def _values(block: "pa.Array", kind: type[np.generic]) -> NDArray[Any]:
    """A block's values as they are in memory: Arrow's own conversion would import pandas."""
    return np.frombuffer(block.buffers()[1], kind)[block.offset : block.offset + len(block)]


def _bits(block: "pa.Array", buffer: int) -> Booleans:
    """Buffer 0 of a block says which cells are not empty; buffer 1 of flags holds their values."""
    bits = np.unpackbits(np.frombuffer(block.buffers()[buffer], np.uint8), bitorder="little")
    return bits[block.offset : block.offset + len(block)].view(np.bool_)
