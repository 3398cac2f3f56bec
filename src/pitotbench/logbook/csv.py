"""Read and write CSV logs: `#` lines with a TOML header, a line of column names, one line a row."""

import gzip
import re
import zlib
from codecs import getincrementaldecoder
from collections.abc import Callable, Mapping
from csv import Error as CsvError
from csv import reader as csv_rows
from dataclasses import dataclass
from io import BytesIO
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import tomli_w
from numpy.typing import NDArray

from pitotbench.logbook.columns import Column, Table, parse_header, require_few_columns
from pitotbench.records import BadInputError
from pitotbench.units import Booleans

if TYPE_CHECKING:
    import pyarrow as pa
    from pyarrow import csv


# A plain CSV table, block by block into arrays: what is in memory is the columns and a few blocks
# of the file. A column's type is that of its first block. Whole numbers and empty columns count as
# floats. Where a later block does not fit, or a column holds anything but numbers, true and false,
# or text, the table is not plain: the caller reads the file as a whole, which takes more memory and
# can name the row.

BLOCK = 1 << 20  # bytes of the file that are parsed at a time
_SPARE = 1.1  # times the rows that are expected from the first block and the size of the file

Types = dict[str, "pa.DataType"]


class _NotPlainError(Exception):
    """The table has to be read as a whole."""


def read_blocks(
    open_reader: "Callable[[Types | None], csv.CSVStreamingReader]", size: int
) -> dict[str, Column] | None:
    """The columns by name, in file order; None for a table that is not plain.

    `open_reader` opens the file with column types, or with None to have them inferred; `size` is
    that of the table [bytes]. An empty cell is NaN among numbers, None among texts.
    """
    import pyarrow as pa

    columns: dict[str, _Growing] = {}
    try:
        schema = open_reader(None).schema
        if len(set(schema.names)) < len(schema.names):
            raise _NotPlainError
        types = {field.name: _plain_type(field.type) for field in schema}
        for block in open_reader(types):
            if not block.num_rows:
                continue
            expected = int(_SPARE * block.num_rows * max(1.0, size / BLOCK))
            for name, values in zip(block.schema.names, block.columns, strict=True):
                columns.setdefault(name, _Growing(types[name], expected)).append(values)
    except (pa.ArrowInvalid, UnicodeDecodeError, _NotPlainError):
        return None
    return {name: column.whole() for name, column in columns.items()} or None


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
        return (
            self._values
            if self._texts is None
            else np.array(list(self._texts), dtype=object)[self._values]
        )


def _numbered(block: "pa.DictionaryArray", texts: dict[str | None, int]) -> NDArray[np.intp]:
    """The numbers of a block's texts; a new text gets a number."""
    codes = _values(block.indices, np.int32)
    if block.null_count:
        codes = np.where(_bits(block.indices, 0), codes, -1)
    different = [*block.dictionary.to_pylist(), *([None] if block.null_count else [])]
    numbers: NDArray[np.intp] = np.array(
        [texts.setdefault(text, len(texts)) for text in different], dtype=np.intp
    )
    return numbers.take(codes)


def _values(block: "pa.Array", kind: type[np.generic]) -> NDArray[Any]:
    """A block's values as they are in memory: Arrow's own conversion would import pandas."""
    return np.frombuffer(block.buffers()[1], kind)[block.offset : block.offset + len(block)]


def _bits(block: "pa.Array", buffer: int) -> Booleans:
    """Buffer 0 of a block says which cells are not empty; buffer 1 of flags holds their values."""
    bits = np.unpackbits(np.frombuffer(block.buffers()[buffer], np.uint8), bitorder="little")
    return bits[block.offset : block.offset + len(block)].view(np.bool_)


_EMPTY = [
    *("", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "null", "NULL"),
    *("-9999", "-9999.0", "-9999.00", "-9999.0000", "-99999"),  # of research airplanes
]
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_VALUE = re.compile(
    r"[+-]?[\d.,]+([eE][+-]?\d+)?$|\d+:\d\d|\d+[-/.]\d+[-/.]\d"
)  # a number, a clock time or a date
_MOST_UNPACKED = 400 << 20  # bytes: a day at 10 Hz in text
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
    """How a table is written: the byte at which it begins, the separator, the decimal mark, and how
    many lines of units or other names stand between the names and the first row."""

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
    text = _as_utf8(path)
    with text.open() as file:
        above, comments, first_line = _split(file)
        head = [first_line, *islice(file, _MOST_HEAD)]
    place = _names_line(head)
    above += sum(map(len, head[:place]))
    comments += [line.decode("utf-8", errors="replace").strip() for line in head[:place]]
    first_line, *below = [*head[place:], *[b""] * _FEWEST_BELOW][: _MOST_BETWEEN + 2]
    if not first_line.strip() or any("\ufffd" in comment for comment in comments):
        _require_text(text.bytes())
    if not first_line.strip():
        raise BadInputError(
            "the file is empty: there is no line of column names"
            + (", only comments" if comments else "")
        )
    delimiter = _delimiter(first_line, below[-1])
    require_few_columns(first_line.count(delimiter.encode()) + 1)
    cells = [_cells(line, delimiter) for line in below]
    between = _lines_between(cells)
    form = _Form(above, delimiter, _decimal(cells[between], delimiter), between)
    header, warnings = parse_header("\n".join(comments))
    columns, ragged = _columns(text, form)
    rows = len(columns[0][1])
    warnings += _check_ragged(ragged, rows, between)
    warnings += _check_promise(header.pop(_ROWS, rows), rows)
    names, arrays = zip(*columns, strict=True)
    units = _units(
        [_cells(comment.encode(), delimiter) for comment in comments[-1:]] + cells[:between],
        len(names),
    )
    return Table(tuple(name.strip() for name in names), arrays, header, tuple(warnings), units)


@dataclass(frozen=True, slots=True)
class _Text:
    """The UTF-8 text of a file: that on the disk, or, of a packed file or one in UTF-16, that in
    memory.
    """

    path: Path
    recoded: bytes | None

    def open(self) -> BinaryIO:
        return self.path.open("rb") if self.recoded is None else BytesIO(self.recoded)

    def bytes(self) -> bytes:
        return self.path.read_bytes() if self.recoded is None else self.recoded

    def size(self) -> int:
        return self.path.stat().st_size if self.recoded is None else len(self.recoded)


def _as_utf8(path: Path) -> _Text:
    with path.open("rb") as file:
        begin = file.read(2)
    data = unpacked(path) if begin == _PACKED else None
    if (begin if data is None else data[:2]) not in (b"\xff\xfe", b"\xfe\xff"):
        return _Text(path, data)
    try:
        return _Text(
            path, (path.read_bytes() if data is None else data).decode("utf-16").encode("utf-8")
        )
    except UnicodeDecodeError as error:
        raise BadInputError("not complete UTF-16 text: save the log as UTF-8 CSV") from error


def unpacked(path: Path) -> bytes:
    """Return the bytes of a file, those of a gzip file unpacked.

    Raises BadInputError for a broken one, and for one that unpacks to more than any log holds.
    """
    data = path.read_bytes()
    if not data.startswith(_PACKED):
        return data
    try:
        with gzip.open(path) as file:
            text = file.read(_MOST_UNPACKED + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise BadInputError(
            "not a complete gzip file: it is damaged or cut off; copy it again from its source"
        ) from error
    if len(text) > _MOST_UNPACKED:
        raise BadInputError(
            f"the gzip file unpacks to more than {_MOST_UNPACKED >> 20} MB: unpack it and cut the "
            "log"
        )
    return text


def _cells(line: bytes, delimiter: str) -> list[str]:
    """Return the cells of a line; none of one that Arrow may read, or refuse with the number of its
    row.

    Such a line holds a carriage return that ends none, or a cell of more than 131,072 letters.
    """
    text = line.decode("utf-8", errors="replace").strip("\r\n")
    try:
        return [cell.strip() for cell in next(csv_rows([text], delimiter=delimiter), [])]
    except CsvError:
        return []


def _names_line(head: list[bytes]) -> int:
    """Return the place of the line of names among the first lines of a table: 0, unless the first
    line is no such line, and one further down is that has as many cells as the rows below it.

    A line of names holds no number, and hardly a text twice.
    """
    # Names have more letters than rows.
    delimiter = _delimiter(max(head, key=lambda line: len(_LETTERS.findall(line))), head[-1])
    cells = [_cells(line, delimiter) for line in head]
    if len(cells) < _FEWEST_BELOW:
        return 0
    width = len(cells[-2])  # the last line may be cut
    if _may_name(cells[0]) and len(cells[0]) == width:
        return 0
    for place, line in enumerate(cells[:-_FEWEST_BELOW]):
        if len(line) == width > 1 and _may_name(line):
            return place
    return 0


def _may_name(cells: list[str]) -> bool:
    texts = [cell for cell in cells if cell and not _NUMBER.fullmatch(cell)]
    distinct = len(set(texts))
    return 2 * len(texts) > len(cells) and distinct > _DISTINCT * len(texts)


def _lines_between(lines: list[list[str]]) -> int:
    """Return how many lines below the names hold no number, where a line with numbers follows them."""
    rows = [any(_VALUE.match(cell) or cell in _EMPTY[1:] for cell in cells) for cells in lines]
    first = rows.index(True) if True in rows else 0
    # A first row of texts alone may be a row: only beside rows of numbers it is none.
    return first if all(any(cells) for cells in lines[:first]) else 0


def _decimal(row: list[str], delimiter: str) -> str:
    """Return the decimal mark of the first row; a comma only where no number has a point."""
    commas = any(_DECIMAL_COMMA.fullmatch(cell) for cell in row)
    points = any(_NUMBER.fullmatch(cell) and "." in cell for cell in row)
    return "," if commas and not points else "."


def _units(lines: list[list[str]], count: int) -> tuple[str, ...]:
    """Return the line of units: the first that has a cell for each column."""
    return next((tuple(cells) for cells in lines if len(cells) == count and count > 1), ())


def _require_text(data: bytes) -> None:
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise BadInputError(f"line {line} is not UTF-8 text: save the log as UTF-8 CSV") from error


def _split(file: BinaryIO) -> tuple[int, list[str], bytes]:
    """Return the position at which the table begins, the comment lines above it and the line of
    column names.
    """
    comments: list[str] = []
    # Spreadsheets begin a UTF-8 file with a byte-order mark of three bytes.
    position = 3 if file.read(3) == b"\xef\xbb\xbf" else 0
    file.seek(position)
    while (line := file.readline())[:1] in (b"#", b"\r", b"\n"):
        text = line.decode("utf-8", errors="replace").strip()
        if text:
            comments.append(text.removeprefix("#").removeprefix(" "))
        position += len(line)
        if position > _MOST_ABOVE:
            raise BadInputError(
                "a megabyte of comments or blank lines stands above the table: this is no log"
            )
    return position, comments, line


class _Utf8:
    """A file whose reading ends in a UnicodeDecodeError where its text is not UTF-8.

    Arrow hands the text of a ragged row to `note`. If it is not UTF-8, Arrow prints a traceback
    instead.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file, self._decode = file, getincrementaldecoder("utf-8")().decode

    def read(self, size: int = -1) -> bytes:
        data = self._file.read(size)
        self._decode(data, final=not data)
        return data

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


def _columns(text: _Text, form: _Form) -> tuple[list[tuple[str, Column]], list[Any]]:
    """Return names and columns in file order, and the rows of another length than the first line."""
    from pyarrow import csv

    ragged: list[Any] = []
    with text.open() as file:

        def open_reader(types: Types | None) -> "csv.CSVStreamingReader":
            file.seek(form.above)
            ragged.clear()
            return csv.open_csv(_Utf8(file), *_options(form, ragged, types))

        found = read_blocks(open_reader, text.size() - form.above)
    if found is not None:
        return list(found.items()), ragged
    data = text.bytes()
    _require_text(data)
    table = _parse(data, form, ragged)
    return [
        (name, to_column(values))
        for name, values in zip(table.column_names, table.columns, strict=True)
    ], ragged


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


def _parse(data: bytes, form: _Form, ragged: list[Any]) -> "pa.Table":
    import pyarrow as pa
    from pyarrow import csv

    ragged.clear()
    try:
        return csv.read_csv(BytesIO(memoryview(data)[form.above :]), *_options(form, ragged))
    except pa.ArrowInvalid as error:
        raise BadInputError(f"not a CSV table: {str(error).splitlines()[0]}") from error


def _options(form: _Form, ragged: list[Any], types: Types | None = None) -> tuple[Any, Any, Any]:
    """Return how to read, parse and convert. Rows of another length than the first line go to
    `ragged`.
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
            column_types=types,
            decimal_point=form.decimal,
        ),
    )


def _check_ragged(ragged: list[Any], rows: int, between: int) -> list[str]:
    """Return a warning for a last line that breaks off. Raise BadInputError for any other line of
    wrong length.
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
            f"{row.expected_columns}{commas}; "
            "correct or remove that row"
        )
    return [
        f"row {number} breaks off after {row.actual_columns} of {row.expected_columns} columns: "
        "dropped"
    ]


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
    return np.add(
        values, 0.0, dtype=np.float64
    )  # a copy of its own, and no minus zero, as of blocks


def write_csv(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write columns below a TOML header. Numbers have the fewest digits that read back to the same
    value.
    """
    import pyarrow as pa
    from pyarrow import csv

    table = pa.table({name: pa.array(values) for name, values in columns.items()})
    above = tomli_w.dumps({_ROWS: table.num_rows, **header})
    with path.open("wb") as file:
        file.write("".join(f"# {line}".rstrip() + "\n" for line in above.splitlines()).encode())
        file.write((",".join(columns) + "\n").encode())
        csv.write_csv(table, file, csv.WriteOptions(include_header=False, quoting_style="needed"))
