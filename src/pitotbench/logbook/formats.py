"""The table of log formats by file suffix: readers of Parquet, MATLAB, DataFlash and ULog, and the
writer.
"""

import os
import re
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import BufferedReader, FileIO, StringIO
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np
import tomli_w

from pitotbench.catalog import Catalog
from pitotbench.logbook.columns import (
    QUANTITIES,
    Column,
    Table,
    atomic,
    parse_header,
    require_few_columns,
    require_regular,
)
from pitotbench.logbook.csv import read_csv, to_column, write_csv
from pitotbench.logbook.mapping import MappedFile
from pitotbench.logbook.recorder_files import read_igc
from pitotbench.records import BadInputError
from pitotbench.records.log import FlightLog

# A compressed file may unpack to far more than the memory holds. Its own metadata tell how much,
# before it is read.

_MANY, _DENSEST = (
    50_000_000,
    100,
)  # values; and values a byte, of which a recorder's file holds less than ten


# What a reader of a library says of a broken file is of its own workings, not of the file.
_AGAIN = ": it is damaged or cut off; copy it again from its source"


def _require_unpackable(values: int, path: Path, kind: str = "numbers") -> None:
    """Raise BadInputError for a file that unpacks to far more values than a recorder writes into so
    many bytes.
    """
    size = path.stat().st_size
    if values > max(_MANY, _DENSEST * size):
        raise BadInputError(
            f"{size:,} bytes would unpack to {values:,} {kind}: no recorder writes such a file"
        )


# Read and write Parquet logs, with the TOML header in the metadata of the schema.

_KEY = b"pitotbench"


def read_parquet(path: Path) -> Table:
    """Read the table of a Parquet file. Raises BadInputError for any other file, and for one that
    is cut off.
    """
    import pyarrow as pa
    from pyarrow import parquet

    try:
        file = parquet.ParquetFile(path, memory_map=False)
        require_few_columns(file.metadata.num_columns)
        _require_unpackable(file.metadata.num_rows * file.metadata.num_columns, path)
        found = file.read()
        names, columns = (
            tuple(found.column_names),
            tuple(to_column(column) for column in found.columns),
        )
    except BadInputError:
        raise
    except (pa.ArrowException, OSError, ValueError) as error:
        raise BadInputError(f"not a complete Parquet file{_AGAIN}") from error
    stored = (found.schema.metadata or {}).get(_KEY, b"")
    header, warnings = parse_header(stored.decode("utf-8", errors="replace"))
    return Table(names, columns, header, tuple(warnings))


def write_parquet(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write columns with a TOML header."""
    import pyarrow as pa
    from pyarrow import parquet

    table = pa.table({name: pa.array(values) for name, values in columns.items()})
    metadata = {_KEY: tomli_w.dumps(header).encode()}
    parquet.write_table(table.replace_schema_metadata(metadata), path, compression="zstd")


# The tables of a log's topics by name, and the parameters of the autopilot by name.
Topics = tuple[dict[str, Table], dict[str, Any]]

_MAGIC, _TEXT = b"\xa3\x95", b"FMT,"  # begins every message, and a log of messages as text


def read_messages(path: Path, topics: Sequence[str]) -> Topics:
    """Return the tables of some kinds of message and the log's parameters.

    Kinds that the log lacks are left out. Values are in the units that the log states for
    its fields (a latitude in degrees, not in 1e-7 of them). Raises
    BadInputError where pymavlink is not installed or the file is not a DataFlash log.
    """
    try:
        # an extra: most users never read a DataFlash log
        from pymavlink.DFReader import DFReader_binary, DFReader_text
    except ImportError as error:
        raise BadInputError(
            "reading an ArduPilot DataFlash log needs pymavlink: pip install 'pitotbench[logs]'"
        ) from error
    with path.open("rb") as file:
        begin = file.read(len(_TEXT))
    if not begin.startswith(_MAGIC) and begin != _TEXT:
        raise BadInputError("not an ArduPilot DataFlash log: it does not begin with a message")
    rows: dict[str, list[Any]] = {}
    held: dict[str, Any] = {}
    said: list[str] = []
    try:
        with _heard(said):
            read = DFReader_text if begin == _TEXT else DFReader_binary
            log = read(str(path), zero_time_base=True)
            while (message := log.recv_match(type=[*topics, "PARM"])) is not None:
                if message.get_type() == "PARM":
                    held[message.Name] = message.Value
                else:
                    rows.setdefault(message.get_type(), []).append(message)
        ends = [
            log.offsets[kind][-1] + form.len
            for kind, form in log.formats.items()
            if begin != _TEXT and log.offsets[kind]
        ]
        columns = {
            kind: {
                name: np.array([getattr(message, name) for message in messages])
                for name in messages[0].get_fieldnames()
            }
            for kind, messages in rows.items()
        }
    except Exception as error:  # pymavlink lets struct, index and key errors out of a broken file
        raise BadInputError(
            f"not a complete DataFlash log: a message does not fit its format{_AGAIN}"
        ) from error
    warnings = _damage("pymavlink", said, max(ends, default=0) > log.data_len)
    tables = {
        kind: Table(tuple(found), tuple(found.values()), warnings=warnings)
        for kind, found in columns.items()
    }
    return tables, held


@contextmanager
def _heard(said: list[str]) -> Iterator[None]:
    """Keep the lines that a library prints of what it skips; its compiled part writes to the
    descriptor itself.
    """
    with TemporaryFile() as file, redirect_stdout(StringIO()) as printed, redirect_stderr(printed):
        own = os.dup(2)
        os.dup2(file.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(own, 2)
            os.close(own)
            file.seek(0)
            said += (
                printed.getvalue() + file.read().decode("utf-8", errors="replace")
            ).splitlines()


def _damage(library: str, lines: list[str], broken: bool) -> tuple[str, ...]:
    """Return warnings of what a library printed of damage, and of a log whose last message breaks
    off.
    """
    more = f" and {len(lines) - 1:,} more remarks" if len(lines) > 1 else ""
    told = (
        [f"the file is damaged, rows may be missing ({library}: {lines[0]}{more})"] if lines else []
    )
    return (
        *told,
        *(["the last message of the log breaks off: its end is missing"] if broken else []),
    )


def read_topics(path: Path, topics: Sequence[str]) -> Topics:
    """Return the tables of some topics and the log's parameters; topics that the log lacks are left
    out.

    Names are those of `ulog2csv`: `sensor_gps_0` is the first `sensor_gps`.
    Raises BadInputError where pyulog is not installed or the file is not a ULog.
    """
    try:
        from pyulog import ULog  # an extra: most users never read a ULog
    except ImportError as error:
        raise BadInputError(
            "reading a ULog needs pyulog: pip install 'pitotbench[logs]'"
        ) from error
    wanted = [re.sub(r"_\d+$", "", topic) for topic in topics]
    said: list[str] = []
    try:
        with _Watched(FileIO(path)) as file, _heard(said):
            log = ULog(file, message_name_filter_list=wanted)
    except Exception as error:  # pyulog lets struct, index and key errors out of a broken file
        raise BadInputError(f"not a complete ULog{_AGAIN}") from error
    if log.file_corruption and not said:
        said.append("a message of the wrong length")
    warnings = _damage("pyulog", said, file.broken)
    tables = {
        f"{each.name}_{each.multi_id}": Table(
            tuple(each.data), tuple(map(np.asarray, each.data.values())), {}, warnings
        )
        for each in log.data_list
    }
    changed = {name: value for _, name, value in log.changed_parameters}
    return tables, {**log.initial_parameters, **changed}


class _Watched(BufferedReader):
    """A file that knows whether the last reading met its end inside a message: the head of one is
    three bytes.
    """

    broken = False

    def read(self, size: int | None = -1, /) -> bytes:
        """Read as any file does."""
        data = super().read(size)
        self.broken = size is not None and len(data) < size and (len(data) > 0 or size != 3)
        return data


# Logs that hold topics, each with a clock of its own, by file suffix. A new one is one file and one
# line here.

ReadTopics = Callable[[Path, Sequence[str]], Topics]


@dataclass(frozen=True, slots=True)
class TopicReader:
    """How the files of one suffix are read, and the shipped mapping that suits them.

    `read_named` returns those of the wanted topics that are there.
    """

    kind: str
    mapping: str
    read_named: ReadTopics

    def read(
        self, path: Path, files: Sequence[MappedFile]
    ) -> tuple[list[Table | None], dict[str, Any]]:
        """Return the table of each file of a mapping, None for an optional one that is absent, and
        the parameters of the log.

        Raises BadInputError for a missing topic, with those that are there.
        """
        wanted = [
            [pattern.removeprefix("*").removesuffix(".csv") for pattern in entry.patterns]
            for entry in files
        ]
        require_regular(path)
        found, held = self.read_named(path, [name for names in wanted for name in names])
        missing = [
            " or ".join(names)
            for names, entry in zip(wanted, files, strict=True)
            if not entry.optional and not found.keys() & set(names)
        ]
        if missing:
            known = ", ".join(sorted(found)) or "none of those wanted"
            raise BadInputError(
                f"the {self.kind} holds no topic {', '.join(missing)}; it holds {known}: set the "
                "autopilot to log the airspeed sensor, the barometer and the GPS, and fly again"
            )
        tables = [next((found[name] for name in names if name in found), None) for names in wanted]
        return tables, held


TOPIC_READERS = {
    ".ulg": TopicReader("ULog", "px4", read_topics),
    ".bin": TopicReader("DataFlash log", "ardupilot", read_messages),
    ".log": TopicReader("DataFlash log", "ardupilot", read_messages),
}


def topics_of(path: Path) -> TopicReader | None:
    """Return the reader of a log that holds topics; None for another, as a .log that is a table."""
    reader = TOPIC_READERS.get(path.suffix.lower())
    if reader is not None and path.suffix.lower() == ".log" and path.is_file():
        with path.open("rb") as file:
            begin = file.read(len(_TEXT))
        return reader if begin.startswith(_MAGIC) or begin == _TEXT else None
    return reader


# Read the variables of a .mat file of version 7.3, which is HDF5. Needs h5py, of the extra
# pitotbench[hdf5].

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_USER_BLOCK = 512  # bytes of text that MATLAB puts before the HDF5 file
_CHARACTERS = b"char"


def load_hdf5(path: Path) -> dict[str, Any]:
    """Return the variables of a file by name: arrays as MATLAB shows them, texts, and structs as
    dictionaries.

    Raises BadInputError where h5py is not installed or the file is broken.
    """
    try:
        import h5py  # an extra: most users never read such a file
    except ImportError as error:
        raise BadInputError(
            "a .mat file of version 7.3 needs h5py: pip install 'pitotbench[hdf5]', or "
            "save('log.mat', '-v7')"
        ) from error
    try:
        with h5py.File(path, "r") as file:
            sizes = [0]
            file.visititems(lambda _, item: sizes.append(getattr(item, "size", 0) or 0))
            _require_unpackable(sum(sizes), path)
            return _fields(file, h5py.HardLink)
    except BadInputError:
        raise
    except Exception as error:  # h5py lets OS, key and runtime errors out of a broken file
        raise BadInputError(f"not a complete .mat file of version 7.3{_AGAIN}") from error


def _fields(group: Any, held: type) -> dict[str, Any]:
    """Return what a group itself holds: a link of another kind may lead into another file."""
    names = [name for name in group if not name.startswith("#")]
    return {
        name: _value(group[name], held)
        for name in names
        if isinstance(group.get(name, getlink=True), held)
    }


def _value(item: Any, held: type) -> Any:
    """Return the value of a dataset, or of a group (a struct) by field."""
    if hasattr(item, "items"):
        return _fields(item, held)
    if item.external or item.is_virtual:
        raise BadInputError(f"{item.name!r} lies in another file; save the variables in one")
    if item.attrs.get("MATLAB_class", b"") == _CHARACTERS:
        return "".join(map(chr, np.asarray(item[()]).ravel()))
    array = np.asarray(item[()])
    if array.dtype.kind in "SO" and array.ndim == 0:
        found = item[()]
        return found.decode("utf-8", errors="replace") if isinstance(found, bytes) else str(found)
    return array.T  # MATLAB stores column by column


# Read and write MATLAB files: one variable a column (or one struct, or one matrix of them), the
# header as text. Files of version 7.3 are HDF5; `mat73_format` reads them. Written are files of
# version 5.

_HEADER = "header"
_IDENTIFICATION = "fdata"
_MATRIX, _COMPRESSED = (
    14,
    15,
)  # miMATRIX and miCOMPRESSED: kinds of a variable, which holds further elements
_KINDS = {
    *range(1, 8),
    9,
    *range(12, 19),
}  # of the elements of a file: SciPy's reader dies of another
_DIMENSIONS = 5  # miINT32: the kind of the element that holds the dimensions of a variable
_NUMERIC = range(6, 16)  # classes of a variable: double to unsigned integers of 64 bits
_BYTES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8}  # of a number of each kind
_DATA, _UNITS = "data", ("units", "unit")  # fields of a struct that is one channel
_RATES = ("rate", "samplerate", "sample_rate", "fs")  # its samples a second
_ROUNDING = 1e-6  # of a sample


def read_mat(path: Path) -> Table:
    """Read the vectors of a .mat file, or of the only struct in it.

    A matrix with a row a sample gives the columns `NAME(:,1)`, `NAME(:,2)`, ... Beside the array
    `fdata` of SIDPAC the other variables, which hold no samples, are left out. A struct with a
    field `data` (and `units`, `Rate`) is one channel; channels of several rates come at the middle
    one of these. Single numbers and texts beside the vectors are left
    out. Raises BadInputError for a file that is not such a file, is cut off, or holds vectors of
    different lengths.
    """
    variables = {k: v for k, v in _load(path).items() if not k.startswith("__")}
    # MATLAB users often save one struct with a field a channel instead of many variables.
    # A struct of texts beside it is about the flight.
    structs = [
        v
        for v in variables.values()
        if isinstance(v, dict)
        and _DATA not in v
        and not all(isinstance(x, str) for x in v.values())
    ]
    if len(structs) == 1:
        variables = {_HEADER: variables.get(_HEADER, ""), **structs[0]}
    stored = variables.pop(_HEADER, "")
    header, warnings = parse_header(stored if isinstance(stored, str) else "")
    if np.ndim(variables.get(_IDENTIFICATION, 0.0)) == 2:
        variables = {_IDENTIFICATION: variables[_IDENTIFICATION]}
    found: dict[str, tuple[Column, str]] = {}
    for name, value in variables.items():
        own = _columns_of(name, value)
        found |= own
        if not own and not isinstance(value, dict):
            warnings.append(f"variable {name!r} is left out: its cells are no numbers or texts")
    if warnings and not found:
        raise BadInputError(f"{'; '.join(warnings)}; save each channel as a vector of numbers")
    vectors = {name: pair for name, pair in found.items() if len(pair[0]) > 1} or found
    if len({len(column) for column, _ in vectors.values()}) > 1:
        vectors = _on_one_clock(vectors, variables)
    lengths = {
        len(column): name for name, (column, _) in reversed(vectors.items())
    }  # the first name of each
    if len(lengths) > 1:
        listing = ", ".join(f"{name} {length}" for length, name in reversed(lengths.items()))
        raise BadInputError(f"the variables differ in length ({listing}); keep one row a sample")
    columns, units = zip(*vectors.values(), strict=True) if vectors else ((), ())
    return Table(tuple(vectors), columns, header, tuple(warnings), units if any(units) else ())


def _on_one_clock(
    vectors: dict[str, tuple[Column, str]], variables: Mapping[str, Any]
) -> dict[str, tuple[Column, str]]:
    """Return channels of several rates at the middle one of these, with their time: each with the
    last sample before it. Channels without a rate are left out; all stay where none states it.
    """
    structs = {name: value for name, value in variables.items() if isinstance(value, dict)}
    rates = {
        name: float(np.ravel(rate)[0])  # of version 7.3 a number is a matrix
        for name, value in structs.items()
        for key, rate in value.items()
        if key.lower() in _RATES and np.asarray(rate).dtype.kind in "fiu" and np.all(rate)
    }
    if not rates:
        return vectors
    base = sorted(rates.values())[len(rates) // 2]
    seconds = min(len(vectors[name][0]) / rate for name, rate in rates.items())
    time = np.arange(int(seconds * base + _ROUNDING)) / base
    found: dict[str, tuple[Column, str]] = {"time_s": (time, "s")}
    for name, rate in rates.items():
        column, unit = vectors[name]
        found[name] = (column[(time * rate + _ROUNDING).astype(np.intp)], unit)
    return found


def _load(path: Path) -> dict[str, Any]:
    with path.open("rb") as file:
        begin = file.read(_USER_BLOCK + len(_SIGNATURE))
    if begin.startswith(_SIGNATURE) or begin[_USER_BLOCK:] == _SIGNATURE:
        return load_hdf5(path)
    from scipy.io import loadmat

    _require_readable(path)
    try:
        found: dict[str, Any] = loadmat(path, simplify_cells=True)
        return found
    # SciPy's reader lets struct, zlib, index and type errors out of a broken file.
    except Exception as error:
        raise BadInputError(f"not a complete .mat file{_AGAIN}") from error


def _require_readable(path: Path) -> None:
    """Raise BadInputError for a .mat file of version 5 that unpacks to too much, or has a broken
    variable.

    A variable states its size in its first eight bytes, so that it is known before the rest is
    unpacked.
    """
    unpacked = 0
    with path.open("rb") as file:
        order = "<" if file.read(128)[126:] == b"IM" else ">"
        while len(head := file.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", head)
            elements = file.read(min(size, path.stat().st_size))
            if kind == _COMPRESSED:
                unpack = zlib.decompressobj()
                try:
                    kind, size = struct.unpack(f"{order}II", unpack.decompress(elements, 8))
                    unpacked += size
                    _require_unpackable(unpacked, path, "bytes")
                    elements = unpack.decompress(unpack.unconsumed_tail, size)
                except (zlib.error, struct.error) as error:
                    raise BadInputError(f"not a complete .mat file{_AGAIN}") from error
            if kind == _MATRIX:
                _require_whole(elements, order)


def _require_whole(elements: bytes, order: str) -> None:
    """Raise BadInputError for the elements of a variable that SciPy's reader would die of.

    Those are an element of no kind, one that ends behind its variable, and numbers of another count
    than their dimensions tell. A small element holds its data in its tag.
    """
    place, held = 0, list[tuple[int, bytes]]()
    while len(tag := elements[place : place + 8]) == 8 and any(tag):
        kind, size = struct.unpack(f"{order}II", tag)
        if small := kind >> 16:
            kind, size, data = kind & 0xFFFF, small, tag[4 : 4 + small]
        else:
            data = elements[place + 8 : place + 8 + size]
        if kind not in _KINDS or len(data) < size:
            raise BadInputError(
                f"not a complete .mat file: an element of the kind {kind} and {size} bytes"
                "; copy it again from its source"
            )
        if kind == _MATRIX:
            _require_whole(data, order)
        held.append((kind, data))
        place += 8 if small else 8 + -(-size // 8) * 8
    if (
        len(held) < 3
        or len(held[0][1]) != 8
        or (made := struct.unpack(f"{order}I", held[0][1][:4])[0] & 0xFF) > 16
    ):
        return  # no variable, or one of a class of MATLAB's own
    kind, data = held[1]
    if kind != _DIMENSIONS or len(data) % 4 or len(data) < 8:
        raise BadInputError(
            f"not a complete .mat file: dimensions of {len(data)} bytes; copy it again"
        )
    dimensions = np.frombuffer(data, f"{order}i4")
    if made in _NUMERIC and len(held) > 3:
        kind, data = held[3]
        if len(data) != np.prod(dimensions, dtype=float) * _BYTES.get(kind, 0):
            raise BadInputError(
                f"not a complete .mat file: {len(data)} bytes for {dimensions.tolist()} numbers"
                "; copy it again from its source"
            )


def _columns_of(name: str, value: object) -> dict[str, tuple[Column, str]]:
    """Return the columns of a variable with their units: one of a vector or channel, several of a
    matrix.
    """
    if isinstance(value, dict):
        stated = {key.lower(): found for key, found in value.items()}
        unit = next((str(stated[key]) for key in _UNITS if key in stated), "")
        value = value.get(_DATA)
        return {} if _is_mixed(value) else {name: (_vector(name, value), unit)}
    if _is_mixed(value):
        return {}
    array = np.asarray(value)
    if array.ndim == 2 and min(array.shape) > 1 and array.dtype.kind in "fiu":
        return {f"{name}(:,{k + 1})": (array[:, k], "") for k in range(array.shape[1])}
    return {name: (_vector(name, value), "")}


def _is_mixed(value: object) -> bool:
    """Return whether a variable is no array of numbers or texts: none, a cell array of others, an
    object.
    """
    if isinstance(value, np.ndarray) and value.dtype.kind != "O":
        return value.dtype.kind not in "fiubUS"
    cells = value if isinstance(value, list) else np.ravel(np.asarray(value, dtype=object))
    return any(not isinstance(cell, str | float | int | np.number | np.bool_) for cell in cells)


def _vector(name: str, value: object) -> Column:
    array = np.atleast_1d(np.atleast_1d(np.asarray(value)).squeeze())
    if array.ndim != 1:
        raise BadInputError(
            f"variable {name!r} has shape {array.shape}; a column of a log is a vector"
        )
    return np.char.rstrip(array) if array.dtype.kind == "U" else array


def write_mat(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write one column vector a variable, and the header as text."""
    from scipy.io import savemat

    variables = {_HEADER: tomli_w.dumps(header), **columns}
    savemat(path, variables, appendmat=False, do_compression=True, oned_as="column")


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


# Files that are read and never written.
READ_ONLY: dict[str, Callable[[Path], Table]] = {
    ".txt": read_csv,
    ".tsv": read_csv,
    ".log": read_csv,
    ".csv.gz": read_csv,
    ".ict": read_csv,
    ".igc": read_igc,
    ".igc.gz": read_igc,
}


def reader_of(path: Path) -> Callable[[Path], Table]:
    """Return the reader of a file by its suffix. Raises BadInputError for a suffix that is not in
    the tables.
    """
    packed = next((suffix for suffix in READ_ONLY if path.name.lower().endswith(suffix)), None)
    return format_of(path).read if packed is None else READ_ONLY[packed]


def format_of(path: Path) -> Format:
    """Return the format of a file by its suffix. Raises BadInputError for a suffix that is not in
    the table.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise BadInputError(
            f"a log ends in {', '.join(FORMATS)}, not in {suffix or 'nothing'!r}; rename or "
            "convert it "
            f"(read only: {', '.join(dict.fromkeys([*READ_ONLY, *TOPIC_READERS]))})"
        )
    return FORMATS[suffix]


# Write a FlightLog to a file.


def write_log(log: FlightLog, path: Path | str) -> Path:
    """Write a log with canonical columns, in the format of the path's suffix, and return the path.

    An error leaves no incomplete file. Raises BadInputError for an unknown suffix or an unwritable
    place.
    """
    target = Path(path)
    try:
        kind = format_of(target)
    except BadInputError as error:
        raise BadInputError(f"{target}: {error}") from error
    columns = {QUANTITIES[name].column: values for name, values in log.channels().items()}
    with atomic(target) as temporary:
        kind.write(temporary, columns, log.header)
    return target
