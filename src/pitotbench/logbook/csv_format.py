"""CSV: `#` lines with a TOML header, a line of column names, one line a row."""

from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pitotbench.logbook.header import parse_header
from pitotbench.logbook.table import Column, Table
from pitotbench.records.errors import BadInputError
from pitotbench.records.toml_text import write_toml

if TYPE_CHECKING:
    import pyarrow as pa

_EMPTY = ["", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "null", "NULL"]
_ROWS = "rows"  # header entry: how many rows were written; more than are found means a cut file


def read_csv(path: Path) -> Table:
    """The table of a CSV file with commas, semicolons or tabs.

    Raises BadInputError for a file that is empty, no text, or has rows of another length than its first line;
    a last line that breaks off is dropped with a warning.
    """
    data = path.read_bytes()
    _require_text(data)
    above, comments = _split(data)
    header, warnings = parse_header("\n".join(comments))
    first_line = data[above:].split(b"\n", 1)[0]
    if not first_line.strip():
        raise BadInputError("the file is empty: there is no line of column names" + _only(comments))
    ragged: list[Any] = []
    found = _parse(data, above, _delimiter(first_line), ragged)
    warnings += _check_ragged(ragged, found.num_rows)
    warnings += _check_promise(header.pop(_ROWS, found.num_rows), found.num_rows)
    columns = tuple(to_column(column) for column in found.columns)
    return Table(tuple(name.strip() for name in found.column_names), columns, header, tuple(warnings))


def _require_text(data: bytes) -> None:
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise BadInputError(f"line {line} is not UTF-8 text: save the log as UTF-8 CSV") from error


def _split(data: bytes) -> tuple[int, list[str]]:
    """Where the table begins, and the comment lines above it."""
    position, comments = (3 if data.startswith(b"\xef\xbb\xbf") else 0), []
    while data[position : position + 1] in (b"#", b"\r", b"\n"):
        end = data.find(b"\n", position)
        end = len(data) if end < 0 else end + 1
        line = data[position:end].decode("utf-8", errors="replace").strip()
        if line:
            comments.append(line.removeprefix("#").removeprefix(" "))
        position = end
    return position, comments


def _only(comments: list[str]) -> str:
    return ", only comments" if comments else ""


def _check_promise(promised: object, found: int) -> list[str]:
    """Fewer rows than the header states mean a cut file."""
    if not isinstance(promised, int) or isinstance(promised, bool):
        return [f"the header's `{_ROWS}` is not a number of rows: it is not used"]
    if found < promised:
        return [f"the header promises {promised} rows, the file holds {found}: its end is missing"]
    return []


def _delimiter(first_line: bytes) -> str:
    return max(",;\t", key=lambda mark: first_line.count(mark.encode()))


def _parse(data: bytes, above: int, delimiter: str, ragged: list[Any]) -> "pa.Table":
    import pyarrow as pa
    from pyarrow import csv

    def note(row: Any) -> str:
        ragged.append(row)
        return "skip"

    try:
        return csv.read_csv(
            BytesIO(memoryview(data)[above:]),
            read_options=csv.ReadOptions(use_threads=False),  # else a ragged row has no number
            parse_options=csv.ParseOptions(delimiter=delimiter, invalid_row_handler=note),
            convert_options=csv.ConvertOptions(null_values=_EMPTY, strings_can_be_null=True),
        )
    except pa.ArrowInvalid as error:
        raise BadInputError(f"not a CSV table: {str(error).splitlines()[0]}") from error


def _check_ragged(ragged: list[Any], rows: int) -> list[str]:
    """A broken last line is a cut file: usable without it. Any other line is an error."""
    if not ragged:
        return []
    row = ragged[0]
    number = row.number - 1  # Arrow counts the line of names
    if len(ragged) > 1 or number != rows + 1 or row.actual_columns > row.expected_columns:
        commas = " (decimal commas? write decimal points)" if row.actual_columns == 2 * row.expected_columns else ""
        raise BadInputError(
            f"row {number} has {row.actual_columns} columns, the first line names {row.expected_columns}{commas}; "
            "mend or remove that row"
        )
    return [f"row {number} breaks off after {row.actual_columns} of {row.expected_columns} columns: dropped"]


def to_column(column: "pa.ChunkedArray") -> Column:
    """An Arrow column as an array: floats with NaN for empty cells, booleans, or objects."""
    import pyarrow as pa

    if pa.types.is_null(column.type):
        return np.full(len(column), np.nan)
    if pa.types.is_dictionary(column.type):
        column = column.cast(column.type.value_type)
    values: Column = column.to_numpy()
    return values.astype(np.float64) if values.dtype.kind in "iu" else values


def write_csv(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write columns below a TOML header; numbers with the fewest digits that read back equal."""
    import pyarrow as pa
    from pyarrow import csv

    table = pa.table({name: pa.array(values) for name, values in columns.items()})
    above = write_toml({_ROWS: table.num_rows, **header})
    with path.open("wb") as file:
        file.write("".join(f"# {line}".rstrip() + "\n" for line in above.splitlines()).encode())
        file.write((",".join(columns) + "\n").encode())
        csv.write_csv(table, file, csv.WriteOptions(include_header=False, quoting_style="needed"))
