"""Read and write CSV logs: `#` lines with a TOML header, a line of column names, one line a row."""

import gzip
import re
import zlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from csv import Error as CsvError
from csv import reader as csv_rows
from dataclasses import dataclass
from io import BytesIO
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import tomli_w

from pitotbench.logbook.columns import Column, Table, parse_header, require_few_columns
from pitotbench.logbook.damage import complete
from pitotbench.logbook.other_kinds import headless
from pitotbench.records import BadInputError
from pitotbench.records.intake import MOST_UNPACKED
from pitotbench.units import Array

if TYPE_CHECKING:
    import pyarrow as pa


BLOCK = 1 << 20  # bytes of the file that are parsed at a time

_EMPTY = [
    *("", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "null", "NULL"),
    *("-9999", "-9999.0", "-9999.00", "-9999.0000", "-99999"),  # of research airplanes
]
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
# a number, a clock time or a date
_VALUE = re.compile(r"[+-]?[\d.,]+([eE][+-]?\d+)?$|\d+:\d\d|\d+[-/.]\d+[-/.]\d")
_PACKED = b"\x1f\x8b"  # begins every gzip file
_MOST_BETWEEN = 2  # lines below the names: units, and short names
_LETTERS = re.compile(rb"[A-Za-z]")
_DELIMITERS = [b",", b";", b"\t", b"|"]
_MOST_HEAD = 200  # lines among which the line of names is looked for
_FEWEST_BELOW = 4  # rows below a line of names that show how many cells a row has
_DISTINCT = 0.8  # share of different texts: a line of kinds or masks repeats a few
_MOST_ABOVE = 1 << 20  # bytes of comments and blank lines above the table
_ROWS = "rows"  # header entry: the number of rows written; a file with fewer is cut off


@dataclass(frozen=True, slots=True)
class _Form:
    """How a table is written: begin, separator, decimal mark, and lines below the names.

    The lines, of units or other names, stand above the first row.
    """

    above: int
    delimiter: str
    decimal: str
    between: int


def read_csv(path: Path) -> Table:
    """Read the table of a CSV file with commas, semicolons, tabs or bars, in UTF-8 or UTF-16.

    Decimal commas are read where the separator or quotes leave no doubt. Lines of units or of
    second names below the names are not rows; they become the units of the table. A last line that
    breaks off is dropped with a warning. Raises BadInputError for a file that is empty or is not
    text, and for any other row whose length differs from the first line.
    """
    with _utf8(path) as file:
        return read_text(file)


def read_text(file: BinaryIO) -> Table:
    """Return the table of UTF-8 text, as `read_csv` does of a file."""
    _require_text(file)
    above, comments, first_line = _split(file)
    head = [first_line, *islice(file, _MOST_HEAD)]
    place = _names_line(head)
    above += sum(map(len, head[:place]))
    comments += [line.decode("utf-8", errors="replace").strip() for line in head[:place]]
    first_line, *below = [*head[place:], *[b""] * _FEWEST_BELOW][: _MOST_BETWEEN + 2]
    if not first_line.strip():
        raise BadInputError(
            "the file is empty: there is no line of column names"
            + (", only comments" if comments else "")
            + "; copy it again from its source"
        )
    delimiter = _delimiter(first_line, below[-1])
    if words := headless(_cells(first_line, delimiter)):
        raise BadInputError(words)
    require_few_columns(first_line.count(delimiter.encode()) + 1)
    cells = [_cells(line, delimiter) for line in below]
    between = _lines_between(cells)
    form = _Form(above, delimiter, _decimal(cells[between], delimiter), between)
    header, warnings = parse_header("\n".join(comments))
    names, arrays, ragged = _columns(file, form)
    rows = len(arrays[0])
    warnings += _check_ragged(ragged, rows, between)
    warnings += _check_promise(header.pop(_ROWS, rows), rows)
    # The line of units: the first that has a cell for each column.
    lines = [*(_cells(comment.encode(), delimiter) for comment in comments[-1:]), *cells[:between]]
    units = next((tuple(line) for line in lines if len(line) == len(names) > 1), ())
    return Table(tuple(name.strip() for name in names), arrays, header, tuple(warnings), units)


def _utf8(path: Path) -> BinaryIO:
    """Return the UTF-8 text of a file: on the disk, in memory if packed or in UTF-16."""
    with path.open("rb") as raw:
        begin = raw.read(len(_PACKED))
    data = unpacked(path) if begin == _PACKED else None
    if (begin if data is None else data[:2]) in (b"\xff\xfe", b"\xfe\xff"):
        try:
            data = (path.read_bytes() if data is None else data).decode("utf-16").encode()
        except UnicodeDecodeError as error:
            raise BadInputError("not complete UTF-16 text: save the log as UTF-8 CSV") from error
    return path.open("rb") if data is None else BytesIO(data)


def unpacked(path: Path) -> bytes:
    """Return the bytes of a file, those of a gzip file unpacked.

    Raises BadInputError for a broken one, and for one that unpacks to more than any log holds.
    """
    data = path.read_bytes()
    if not data.startswith(_PACKED):
        return data
    with complete("gzip file", (OSError, EOFError, zlib.error)), gzip.open(path) as file:
        text = file.read(MOST_UNPACKED + 1)
    if len(text) > MOST_UNPACKED:
        raise BadInputError(
            f"the gzip file unpacks to more than {MOST_UNPACKED >> 20} MB: unpack it and cut the "
            "log"
        )
    return text


def _cells(line: bytes, delimiter: str) -> list[str]:
    """Return the cells of a line, none for a line that is left to Arrow.

    Such a line holds a carriage return that ends none, or a cell of more than 131,072 letters.
    Arrow may read it, or refuse it with the number of its row.
    """
    text = line.decode("utf-8", errors="replace").strip("\r\n")
    try:
        return [cell.strip() for cell in next(csv_rows([text], delimiter=delimiter), [])]
    except CsvError:
        return []


def _names_line(head: list[bytes]) -> int:
    """Return the place of the line of names among the first lines of a table, usually 0.

    Another line is taken where the first is no such line and one further down has as many cells as
    the rows below it. A line of names holds no number, and hardly a text twice.
    """
    # Names have more letters than rows.
    delimiter = _delimiter(max(head, key=lambda line: len(_LETTERS.findall(line))), head[-1])
    cells = [_cells(line, delimiter) for line in head]
    if len(cells) < _FEWEST_BELOW:
        return 0
    width = len(cells[-2])  # the last line may be cut
    for place, line in enumerate(cells[:-_FEWEST_BELOW]):
        if len(line) == width > 1 and _may_name(line):
            return place
    return 0


def _may_name(cells: list[str]) -> bool:
    texts = [cell for cell in cells if cell and not _NUMBER.fullmatch(cell)]
    distinct = len(set(texts))
    return 2 * len(texts) > len(cells) and distinct > _DISTINCT * len(texts)


def _lines_between(lines: list[list[str]]) -> int:
    """Return how many lines below the names hold no number, where one with numbers follows."""
    rows = [any(_VALUE.match(cell) or cell in _EMPTY[1:] for cell in cells) for cells in lines]
    first = rows.index(True) if True in rows else 0
    # A first row of texts alone may be a row: only above rows of numbers it is none.
    return first if all(any(cells) for cells in lines[:first]) else 0


def _decimal(row: list[str], delimiter: str) -> str:
    """Return the decimal mark of the first row; a comma only where no number has a point."""
    commas = any(_DECIMAL_COMMA.fullmatch(cell) for cell in row)
    points = any(_NUMBER.fullmatch(cell) and "." in cell for cell in row)
    return "," if commas and not points else "."


def _require_text(file: BinaryIO) -> None:
    """Raise BadInputError, with the line, for a file that is not UTF-8 text.

    Arrow would print a traceback.
    """
    number = 1
    while block := file.read(BLOCK) + (rest := file.readline(BLOCK)):  # whole lines
        if len(rest) == BLOCK:  # the parser takes none of above a block
            number += block.count(b"\n")
            raise BadInputError(f"line {number} has more than a megabyte: it is no row of a log")
        try:
            block.decode("utf-8")
        except UnicodeDecodeError as error:
            number += block.count(b"\n", 0, error.start)
            raise BadInputError(
                f"line {number} is not UTF-8 text: save the log as UTF-8 CSV"
            ) from error
        number += block.count(b"\n")
    file.seek(0)


def _split(file: BinaryIO) -> tuple[int, list[str], bytes]:
    """Return where a table begins, the comment lines above it, and the line of column names."""
    comments: list[str] = []
    # Spreadsheets begin a UTF-8 file with a byte-order mark of three bytes.
    position = 3 if file.read(3) == b"\xef\xbb\xbf" else 0
    file.seek(position)
    # A recorder that opens its file anew leaves a null byte.
    while (line := file.readline()) and (line[:1] == b"#" or not line.strip(b"\0 \t\r\n")):
        text = line.decode("utf-8", errors="replace").strip("\0 \t\r\n")
        if text:
            comments.append(text.removeprefix("#").removeprefix(" "))
        position += len(line)
        if position > _MOST_ABOVE:
            raise BadInputError(
                "a megabyte of comments or blank lines stands above the table: remove them"
            )
    return position, comments, line


def _columns(file: BinaryIO, form: _Form) -> tuple[tuple[str, ...], tuple[Column, ...], list[Any]]:
    """Return names and columns in file order, and the rows of another length than the first line.

    A column has the type of its first block. Where a later one does not fit, Arrow finds the types
    with the whole text in memory.
    """
    import pyarrow as pa
    from pyarrow import csv

    ragged: list[Any] = []
    file.seek(form.above)
    # A copy: Arrow reads ahead in a thread of its own, under which the file would move.
    head = BytesIO(file.read(BLOCK) + file.readline(BLOCK))

    def run(types: Mapping[str, Any]) -> Any:
        file.seek(form.above)
        ragged.clear()
        return to_columns(csv.read_csv(file, *_options(form, ragged, types)))

    try:
        # A whole column of which the first block has integers or nothing may hold any number.
        types = {
            each.name: pa.float64()
            if pa.types.is_integer(each.type) or pa.types.is_null(each.type)
            else each.type
            for each in csv.open_csv(head, *_options(form, [], {})).schema
        }
        with suppress(pa.ArrowInvalid):
            return *run(types), ragged
        return *run({}), ragged
    except pa.ArrowInvalid as error:
        raise BadInputError(
            f"not a CSV table: {str(error).splitlines()[0]}; check its quotation marks, and lines "
            "of above a megabyte"
        ) from error


def _check_promise(promised: object, found: int) -> list[str]:
    """Return a warning where the file has fewer rows than its header states."""
    if not isinstance(promised, int) or isinstance(promised, bool):
        return [f"the header's `{_ROWS}` is not a number of rows: it is not used"]
    if found < promised:
        return [f"the header promises {promised} rows, the file holds {found}: its end is missing"]
    return []


def _delimiter(first_line: bytes, row: bytes = b"") -> str:
    # The most frequent in the line of names; a name may itself hold another, which no row then has.
    marks = [mark for mark in _DELIMITERS if mark in row] or _DELIMITERS
    return max(marks, key=first_line.count).decode()


def _options(form: _Form, ragged: list[Any], types: Mapping[str, Any]) -> tuple[Any, Any, Any]:
    """Return how to read, parse and convert, rows of another length going to `ragged`.

    The length of the first line is the right one.
    """
    from pyarrow import csv

    def note(row: Any) -> str:
        ragged.append(row)
        return "skip"

    return (
        # With threads a ragged row has no number.
        csv.ReadOptions(use_threads=False, block_size=BLOCK, skip_rows_after_names=form.between),
        csv.ParseOptions(delimiter=form.delimiter, invalid_row_handler=note),
        csv.ConvertOptions(
            null_values=_EMPTY,
            strings_can_be_null=True,
            auto_dict_encode=True,
            column_types=types,
            decimal_point=form.decimal,
        ),
    )


def _check_ragged(ragged: list[Any], rows: int, between: int) -> list[str]:
    """Return a warning for a last line that breaks off.

    Raises BadInputError for any other line of wrong length.
    """
    if not ragged:
        return []
    row = ragged[0]
    number = row.number - 1 - between  # Arrow counts the line of names
    if len(ragged) > 1 or number != rows + 1 or row.actual_columns > row.expected_columns:
        commas = (
            " (decimal commas? write decimal points)"
            if row.actual_columns == 2 * row.expected_columns
            else ""
        )
        raise BadInputError(
            f"row {number} has {row.actual_columns} columns, the first line names "
            f"{row.expected_columns}{commas}; correct or remove that row"
        )
    return [
        f"row {number} breaks off after {row.actual_columns} of {row.expected_columns} columns: "
        "dropped"
    ]


def to_columns(table: "pa.Table") -> tuple[tuple[str, ...], tuple[Column, ...]]:
    """Return the names of an Arrow table, and its columns as arrays.

    The arrays are floats with NaN for empty cells, booleans, or objects. Each leaves the table as
    it comes, so that a long log is in memory once.
    """
    import pyarrow as pa

    names, found = tuple(table.column_names), list[Column]()
    while table.num_columns:
        column, table = table.column(0), table.remove_column(0)
        found.append(_to_column(column))
    pa.default_memory_pool().release_unused()  # a third of a long log
    return names, tuple(found)


def _to_column(column: "pa.ChunkedArray") -> Column:
    import pyarrow as pa

    kind = column.type
    if pa.types.is_null(kind):
        return np.full(len(column), np.nan)
    if pa.types.is_dictionary(kind):  # each different text once
        whole = column.unify_dictionaries().combine_chunks()
        texts = np.array([*whole.dictionary.to_pylist(), None], dtype=object)
        places = np.nan_to_num(_numbers([whole.indices]), nan=len(texts) - 1)
        return np.asarray(texts[places.astype(np.intp)])
    if pa.types.is_boolean(kind) and not column.null_count:
        return _numbers(column.cast(pa.uint8()).chunks).astype(np.bool_)
    if pa.types.is_integer(kind) or pa.types.is_floating(kind):
        # A minus zero would turn the direction of a velocity by half a circle.
        return _numbers(column.chunks) + 0.0
    return np.asarray(column.to_numpy())


def _numbers(parts: "Sequence[pa.Array]") -> Array:
    """Return the numbers of Arrow's arrays as floats, NaN for empty cells."""
    import pyarrow as pa

    # Not by `to_numpy`, which loads pandas: that takes longer than a calibration.
    return np.concatenate(
        [
            np.zeros(0),
            *(
                pa.record_batch([each], [""]).to_tensor(null_to_nan=True).to_numpy()[:, 0]
                for each in parts
            ),
        ]
    )


def write_csv(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write columns below a TOML header, in the fewest digits that read back to the same."""
    import pyarrow as pa
    from pyarrow import csv

    table = pa.table({name: pa.array(values) for name, values in columns.items()})
    above = tomli_w.dumps({_ROWS: table.num_rows, **header})
    with path.open("wb") as file:
        file.write("".join(f"# {line}".rstrip() + "\n" for line in above.splitlines()).encode())
        file.write((",".join(columns) + "\n").encode())
        csv.write_csv(table, file, csv.WriteOptions(include_header=False, quoting_style="needed"))
