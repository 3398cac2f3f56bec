"""Read and write MATLAB files: one variable a column (or one struct, or one matrix of them), the
header as text. Files of version 7.3 are HDF5. Written are files of version 5.
"""

import math
import struct
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from pitotbench.logbook.columns import Column, Table, parse_header
from pitotbench.logbook.damage import AGAIN, require_unpackable
from pitotbench.logbook.hdf5 import is_hdf5, load_hdf5
from pitotbench.records import BadInputError

_HEADER = "header"
_IDENTIFICATION = "fdata"
# Kinds of an element, and how many bytes a number or a letter of each has.
_WIDTHS = {
    kind: struct.calcsize(code) for kind, code in enumerate(" bBhHiIf d  qQ  BHI") if code.strip()
}
_MATRIX, _COMPRESSED, _UTF_8 = 14, 15, 16  # a variable, which holds further elements; UTF-8
_KINDS = {*_WIDTHS, _MATRIX, _COMPRESSED}  # SciPy's reader dies of another
_DIMENSIONS = 5  # miINT32: the kind of the element that holds the dimensions of a variable
_NUMERIC = range(6, 16)  # classes of a variable: double to unsigned integers of 64 bits
_CELL, _STRUCTS = 1, (2, 3)  # classes of a list of variables, and of variables by name
_TEXT = 4  # class of a text
_LETTERS = {1, 2, 4, *(kind for kind in _WIDTHS if kind >= _UTF_8)}  # kinds of a text
_SPARSE = 5  # class of a matrix whose indices SciPy's reader does not check
_COMPLEX = 0x800  # the flag of a variable of complex numbers
_DEEPEST = 50  # variables within one another
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
    if is_hdf5(path):
        return load_hdf5(path)
    from scipy.io import loadmat

    _require_readable(path)
    try:
        found: dict[str, Any] = loadmat(path, simplify_cells=True)
        return found
    # SciPy's reader lets struct, zlib, index and type errors out of a broken file.
    except Exception as error:
        raise BadInputError(f"not a complete .mat file{AGAIN}") from error


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
                    require_unpackable(unpacked, path, "bytes")
                    elements = unpack.decompress(unpack.unconsumed_tail, size)
                except (zlib.error, struct.error) as error:
                    raise BadInputError(f"not a complete .mat file{AGAIN}") from error
            if kind == _MATRIX:
                _require_whole(elements, order)


def _require_whole(elements: bytes, order: str, depth: int = 0) -> None:
    """Raise BadInputError for the elements of a variable that SciPy's reader would die of.

    Those are an element of no kind, one that ends behind its variable, numbers of another count
    than their dimensions tell, a part too few, sparse matrices, and variables without an end.
    """
    if depth > _DEEPEST:
        raise BadInputError(
            f"a .mat file whose variables are nested more than {_DEEPEST} deep: save each channel "
            "as a vector of numbers"
        )
    place, held = 0, list[tuple[int, bytes]]()
    while len(tag := elements[place : place + 8]) == 8 and any(tag):
        kind, size = struct.unpack(f"{order}II", tag)
        if small := kind >> 16:  # it holds its data in its tag
            kind, size, data = kind & 0xFFFF, small, tag[4 : 4 + small]
        else:
            data = elements[place + 8 : place + 8 + size]
        if kind not in _KINDS or len(data) < size:
            raise BadInputError(
                f"not a complete .mat file: an element of the kind {kind} and {size} bytes"
                "; copy it again from its source"
            )
        if kind == _MATRIX:
            _require_whole(data, order, depth + 1)
        held.append((kind, data))
        place += 8 if small else 8 + -(-size // 8) * 8
    if len(held) < 3 or len(held[0][1]) != 8:
        return  # no variable
    flags = struct.unpack(f"{order}I", held[0][1][:4])[0]
    if (made := flags & 0xFF) > 16:
        return  # one of a class of MATLAB's own
    if made == _SPARSE:
        raise BadInputError("a .mat file with a sparse matrix: save it as full(x)")
    kind, data = held[1]
    if kind != _DIMENSIONS or len(data) % 4 or len(data) < 8:
        raise BadInputError(
            f"not a complete .mat file: dimensions of {len(data)} bytes; copy it again"
        )
    dimensions = np.frombuffer(data, f"{order}i4")
    parts = held[3:]
    if len(parts) < (
        needed := _parts_needed(made, flags, float(np.prod(dimensions, dtype=float)), parts, order)
    ):
        raise BadInputError(
            f"not a complete .mat file: {len(parts)} parts of a variable that has {needed:,.0f}"
            "; copy it again from its source"
        )
    kinds = _LETTERS if made == _TEXT else {kind for kind in _WIDTHS if kind < _MATRIX}
    for kind, data in parts[: int(needed)] if made == _TEXT or made in _NUMERIC else ():
        count = len(data.decode("utf-8", "replace")) if kind == _UTF_8 else len(data)
        if kind not in kinds or count != np.prod(dimensions, dtype=float) * _WIDTHS[kind]:
            raise BadInputError(
                f"not a complete .mat file: {len(data)} bytes for {dimensions.tolist()} "
                f"{'letters' if made == _TEXT else 'numbers'}; copy it again from its source"
            )


def _parts_needed(
    made: int, flags: int, size: float, parts: list[tuple[int, bytes]], order: str
) -> float:
    """Return how many elements follow the name of a variable of a class and a size."""
    if made not in _STRUCTS:
        return size if made == _CELL else 1.0 + (made in _NUMERIC and flags & _COMPLEX > 0)
    first = made - _STRUCTS[0]  # an object has the name of its class before the names of fields
    fields = [data for _, data in parts[first : first + 2]]
    if [len(data) for data in fields[:1]] != [struct.calcsize("i")] or len(fields) == 1:
        return math.inf
    width: int = struct.unpack(f"{order}i", fields[0])[0]
    return first + 2 + size * (len(fields[1]) // max(1, width))


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
            f"variable {name!r} has shape {array.shape}; a column of a log is a vector: "
            "save it as one, or leave it out"
        )
    return np.char.rstrip(array) if array.dtype.kind == "U" else array


def write_mat(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write one column vector a variable, and the header as text."""
    from scipy.io import savemat

    variables = {_HEADER: tomli_w.dumps(header), **columns}
    savemat(path, variables, appendmat=False, do_compression=True, oned_as="column")
