"""A table as read from a file: named columns, a header, warnings, units. It is not yet a log."""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import date, time, timedelta
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from pitotbench.records.errors import BadInputError

Column = NDArray[Any]
_CLOCK = re.compile(r"\d:[0-5]\d|\d{4}-\d\d-\d\d")  # 14:03:06 or 2026-05-04
_DECIMAL_COMMA = re.compile(r"\s*[+-]?\d*,\d+([eE][+-]?\d+)?\s*")


@dataclass(frozen=True, slots=True)
class Table:
    """Columns in the order of the file, the header, and the warnings of the reader. A name may occur twice."""

    names: tuple[str, ...]
    columns: tuple[Column, ...]
    header: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    units: tuple[str, ...] = ()  # of each column, as a line of units beside that of the names states them

    def __len__(self) -> int:
        return len(self.columns[0]) if self.columns else 0

    def column(self, name: str) -> Column:
        """Return the column of a name. Raises BadInputError where it is missing or given twice."""
        count = self.names.count(name)
        if count != 1:
            raise BadInputError(f"column {name!r} is {'given twice; keep one' if count else 'missing'}")
        return self.columns[self.names.index(name)]


def numbers(name: str, column: Column) -> NDArray[np.float64]:
    """Return a column as floats, with NaN for empty cells.

    Raises BadInputError that names the first row whose cell is not a number.
    """
    if column.dtype.kind in "fiub":
        return np.asarray(column, dtype=np.float64)
    if column.dtype.kind in "mM" and len(column):
        raise BadInputError(f"column {name!r}, row 1: {_no_number(column[0])}")
    values = np.full(len(column), np.nan)
    for i, cell in enumerate(column):
        try:
            values[i] = np.nan if cell is None or (isinstance(cell, str) and not cell.strip()) else float(cell)
        except (TypeError, ValueError):
            raise BadInputError(f"column {name!r}, row {i + 1}: {_no_number(cell)}") from None
    return values


def _no_number(cell: object) -> str:
    """Return why a cell is not a number, and what to write instead."""
    text = str(cell)
    if isinstance(cell, date | time | timedelta | np.datetime64 | np.timedelta64) or _CLOCK.search(text):
        return f"{text!r} is a clock time or a date; write seconds from the start of the log"
    if _DECIMAL_COMMA.fullmatch(text):
        return f"{text!r} has a decimal comma; write decimal points in the whole file"
    return f"{text!r} is not a number; correct or remove that row"


def flags(name: str, column: Column) -> NDArray[np.bool_]:
    """Return a column as booleans. Raises BadInputError that names the first row which is neither."""
    if column.dtype.kind == "b" or (column.dtype.kind in "fiu" and np.isin(column, (0, 1)).all()):
        return np.asarray(column, dtype=np.bool_)
    words = {"true": True, "1": True, "1.0": True, "false": False, "0": False, "0.0": False}
    cells = [words.get(str(cell).lower()) for cell in column]
    if None in cells:
        row = cells.index(None)
        raise BadInputError(f"column {name!r}, row {row + 1}: {str(column[row])!r} is not true or false (1 or 0)")
    return np.array(cells, dtype=np.bool_)


def texts(column: Column) -> NDArray[np.str_]:
    """Return a column as text; an empty cell is an empty text."""
    if column.dtype.kind == "U":
        return column
    first = np.flatnonzero(np.r_[True, column[1:] != column[:-1]][: len(column)])  # labels come in long runs
    cells = np.array(["" if cell is None else str(cell) for cell in column[first]], dtype=np.str_)
    return np.repeat(cells, np.diff(first, append=len(column)))


@contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """Give a temporary path in the folder of `path`; rename it to `path` on success, remove it on failure.

    A reader therefore never finds half a file. Raises BadInputError where the folder does not exist or cannot be
    written.
    """
    # The random part of the name keeps two processes that write the same file apart.
    temporary = path.with_name(f".{path.name}.{uuid4().hex[:8]}.part")
    try:
        yield temporary
        temporary.replace(path)
    except OSError as error:
        raise BadInputError(
            f"{path}: cannot be written: {error.strerror or error}; choose another folder"
        ) from error
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file whole or not at all. Raises BadInputError as `atomic` does."""
    with atomic(path) as scratch:
        scratch.write_text(text, encoding="utf-8")
