"""Read and write CSV logs: `#` lines with a TOML header, a line of column names, one line a row."""

from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from pitotbench.logbook.csv_blocks import BLOCK, Types, read_blocks
from pitotbench.logbook.header import parse_header
from pitotbench.logbook.table import Column, Table
from pitotbench.records.errors import BadInputError
from pitotbench.records.toml_text import write_toml

if TYPE_CHECKING:
    import pyarrow as pa
    from pyarrow import csv

_EMPTY = ["", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "null", "NULL"]
_ROWS = "rows"  # header entry: the number of rows written; a file with fewer is cut off


def read_csv(path: Path) -> Table:
    """Read the table of a CSV file with commas, semicolons or tabs.

    A last line that breaks off is dropped with a warning. Raises BadInputError for a file that is empty or is not
    text, and for any other row whose length differs from the first line.
    """
    with path.open("rb") as file:
        above, comments, first_line = _split(file)
    if not first_line.strip() or any("\ufffd" in comment for comment in comments):
        _require_text(path.read_bytes())
    if not first_line.strip():
        raise BadInputError("the file is empty: there is no line of column names" + _only(comments))
    header, warnings = parse_header("\n".join(comments))
    columns, ragged = _columns(path, above, _delimiter(first_line))
    rows = len(columns[0][1])
    warnings += _check_ragged(ragged, rows)
    warnings += _check_promise(header.pop(_ROWS, rows), rows)
    names, arrays = zip(*columns, strict=True)
    return Table(tuple(name.strip() for name in names), arrays, header, tuple(warnings))


def _require_text(data: bytes) -> None:
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise BadInputError(f"line {line} is not UTF-8 text: save the log as UTF-8 CSV") from error


def _split(file: BinaryIO) -> tuple[int, list[str], bytes]:
    """Return the position at which the table begins, the comment lines above it and the line of column names."""
    comments: list[str] = []
    # Spreadsheets begin a UTF-8 file with a byte-order mark of three bytes.
    position = 3 if file.read(3) == b"\xef\xbb\xbf" else 0
    file.seek(position)
    while (line := file.readline())[:1] in (b"#", b"\r", b"\n"):
        text = line.decode("utf-8", errors="replace").strip()
        if text:
            comments.append(text.removeprefix("#").removeprefix(" "))
        position += len(line)
    return position, comments, line


def _columns(path: Path, above: int, delimiter: str) -> tuple[list[tuple[str, Column]], list[Any]]:
    """Return names and columns in file order, and the rows of another length than the first line."""
    from pyarrow import csv

    ragged: list[Any] = []
    with path.open("rb") as file:

        def open_reader(types: Types | None) -> "csv.CSVStreamingReader":
            file.seek(above)
            ragged.clear()
            return csv.open_csv(file, *_options(delimiter, ragged, types))

        found = read_blocks(open_reader, path.stat().st_size - above)
    if found is not None:
        return list(found.items()), ragged
    data = path.read_bytes()
    _require_text(data)
    table = _parse(data, above, delimiter, ragged)
    return [
        (name, to_column(values)) for name, values in zip(table.column_names, table.columns, strict=True)
    ], ragged


def _only(comments: list[str]) -> str:
    return ", only comments" if comments else ""


def _check_promise(promised: object, found: int) -> list[str]:
    """Return a warning where the file has fewer rows than its header states."""
    if not isinstance(promised, int) or isinstance(promised, bool):
        return [f"the header's `{_ROWS}` is not a number of rows: it is not used"]
    if found < promised:
        return [f"the header promises {promised} rows, the file holds {found}: its end is missing"]
    return []


def _delimiter(first_line: bytes) -> str:
    # The most frequent of the three in the line of names; a name may itself hold one of the others.
    return max(",;\t", key=lambda mark: first_line.count(mark.encode()))


def _parse(data: bytes, above: int, delimiter: str, ragged: list[Any]) -> "pa.Table":
    import pyarrow as pa
    from pyarrow import csv

    ragged.clear()
    try:
        return csv.read_csv(BytesIO(memoryview(data)[above:]), *_options(delimiter, ragged))
    except pa.ArrowInvalid as error:
        raise BadInputError(f"not a CSV table: {str(error).splitlines()[0]}") from error


def _options(delimiter: str, ragged: list[Any], types: Types | None = None) -> tuple[Any, Any, Any]:
    """Return how to read, parse and convert. Rows of another length than the first line go to `ragged`."""
    from pyarrow import csv

    def note(row: Any) -> str:
        ragged.append(row)
        return "skip"

    return (
        csv.ReadOptions(use_threads=False, block_size=BLOCK),  # with threads a ragged row has no number
        csv.ParseOptions(delimiter=delimiter, invalid_row_handler=note),
        csv.ConvertOptions(null_values=_EMPTY, strings_can_be_null=True, column_types=types),
    )


def _check_ragged(ragged: list[Any], rows: int) -> list[str]:
    """Return a warning for a last line that breaks off. Raise BadInputError for any other line of wrong length."""
    if not ragged:
        return []
    row = ragged[0]
    number = row.number - 1  # Arrow counts the line of names
    if len(ragged) > 1 or number != rows + 1 or row.actual_columns > row.expected_columns:
        commas = " (decimal commas? write decimal points)" if row.actual_columns == 2 * row.expected_columns else ""
        raise BadInputError(
            f"row {number} has {row.actual_columns} columns, the first line names {row.expected_columns}{commas}; "
            "correct or remove that row"
        )
    return [f"row {number} breaks off after {row.actual_columns} of {row.expected_columns} columns: dropped"]


def to_column(column: "pa.ChunkedArray") -> Column:
    """Return an Arrow column as an array: floats with NaN for empty cells, booleans, or objects."""
    import pyarrow as pa

    if pa.types.is_null(column.type):
        return np.full(len(column), np.nan)
    if pa.types.is_dictionary(column.type):
        column = column.cast(column.type.value_type)
    values: Column = column.to_numpy()
    if values.dtype.kind not in "iuf":
        return values
    return np.add(values, 0.0, dtype=np.float64)  # a copy of its own, and no minus zero, as of blocks


def write_csv(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write columns below a TOML header. Numbers have the fewest digits that read back to the same value."""
    import pyarrow as pa
    from pyarrow import csv

    table = pa.table({name: pa.array(values) for name, values in columns.items()})
    above = write_toml({_ROWS: table.num_rows, **header})
    with path.open("wb") as file:
        file.write("".join(f"# {line}".rstrip() + "\n" for line in above.splitlines()).encode())
        file.write((",".join(columns) + "\n").encode())
        csv.write_csv(table, file, csv.WriteOptions(include_header=False, quoting_style="needed"))
