"""Read and write MATLAB files: a column is a variable, a field of a struct, or one of a matrix.

The header is text. Files of version 7.3 are HDF5. Written are files of version 5, with one variable
a column.
"""

import pickle
import struct
import subprocess
import sys
import zlib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import numpy as np
import tomli_w

from pitotbench.logbook.columns import QUANTITIES, Column, Table, parse_header, plain_name
from pitotbench.logbook.damage import AGAIN, require_unpackable
from pitotbench.logbook.hdf5 import is_hdf5, load_hdf5
from pitotbench.logbook.synonyms import SYNONYMS
from pitotbench.records import BadInputError

_HEADER = "header"
_IDENTIFICATION = "fdata"
_COMPRESSED = 15  # miCOMPRESSED: the kind of a variable that is packed
_MEMORY = 4 << 30  # bytes that the reader may fill: a list may state any length
# Reads a file (1st argument) below a limit of memory (2nd), where the system has one. It lowers a
# limit that is there, and never lifts it.
_READER = """
import pickle, sys
from contextlib import suppress
from scipy.io import loadmat
with suppress(ImportError, ValueError, OSError):
    import resource
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    most = int(sys.argv[2]) if soft == resource.RLIM_INFINITY else min(int(sys.argv[2]), soft)
    resource.setrlimit(resource.RLIMIT_AS, (most, hard))
pickle.dump(loadmat(sys.argv[1], simplify_cells=True), sys.stdout.buffer)
"""
_DATA, _UNITS = "data", ("units", "unit")  # fields of a struct that is one channel
_RATES = ("rate", "samplerate", "sample_rate", "fs")  # its samples a second
_ROUNDING = 1e-6  # of a sample
_CLOCKS = {*SYNONYMS["time"].split(), *(f"time{suffix}" for suffix in QUANTITIES["time"].suffixes)}


def read_mat(path: Path) -> Table:
    """Read the vectors of a .mat file, or of the only struct in it.

    A matrix with a row a sample gives the columns `NAME(:,1)`, `NAME(:,2)`, ... Beside the array
    `fdata` of SIDPAC the other variables, which hold no samples, are left out. A struct with a
    field `data` (and `units`, `Rate`) is one channel; channels of several rates come at the middle
    one of these. Single numbers and texts beside the vectors are left out. Raises BadInputError for
    a file that is not such a file, is cut off, or holds vectors of different lengths of which the
    most frequent has no time.
    """
    variables = {k: v for k, v in _load(path).items() if not k.startswith("__")}
    # MATLAB users often save one struct with a field a channel instead of many variables.
    # A struct of texts and single numbers beside it is about the flight; a channel with its unit is
    # a struct itself.
    structs = [
        v
        for v in variables.values()
        if isinstance(v, dict)
        and _DATA not in v
        and any(isinstance(x, dict) or np.size(x) > 1 for x in v.values())
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
    vectors, others = _of_the_clock(vectors)
    warnings += others
    columns, units = zip(*vectors.values(), strict=True) if vectors else ((), ())
    return Table(tuple(vectors), columns, header, tuple(warnings), units if any(units) else ())


def _of_the_clock(
    vectors: dict[str, tuple[Column, str]],
) -> tuple[dict[str, tuple[Column, str]], list[str]]:
    """Return the vectors of the most frequent length, and a remark that names the others.

    Another box recorded these at a rate of its own. Raises BadInputError where none of them is a
    time.
    """
    names: dict[int, list[str]] = {}
    for name, (column, _) in vectors.items():
        names.setdefault(len(column), []).append(name)
    if len(names) < 2:
        return vectors, []
    length = max(names, key=lambda each: len(names[each]))
    if not any(plain_name(name).replace(" ", "") in _CLOCKS for name in names[length]):
        listing = ", ".join(f"{some[0]} {each}" for each, some in names.items())
        raise BadInputError(
            f"the variables differ in length ({listing}), and none of the {len(names[length])} of "
            f"{length} is a time: save one time with a row a sample of the air data"
        )
    left = [name for name in vectors if name not in names[length]]
    note = f"variables of another length than the time are left out: {', '.join(left)}"
    return {name: vectors[name] for name in names[length]}, [note]


def _on_one_clock(
    vectors: dict[str, tuple[Column, str]], variables: Mapping[str, Any]
) -> dict[str, tuple[Column, str]]:
    """Return channels of several rates at the middle one of these, with their time.

    Each has its last sample before that time. Channels without a rate are left out; all stay where
    none states it.
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
    _require_unpackable(path)
    # A process of its own reads: a damaged file ends SciPy's reader without an error.
    done = subprocess.run(
        [sys.executable, "-P", "-c", _READER, str(path), str(_MEMORY)],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
    )
    if done.returncode != 0:
        raise BadInputError(f"not a complete .mat file{AGAIN}")
    return cast("dict[str, Any]", pickle.loads(done.stdout))


def _require_unpackable(path: Path) -> None:
    """Raise BadInputError for a .mat file of version 5 that unpacks to too much.

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
                with suppress(zlib.error, struct.error):  # the reader says so
                    stated = zlib.decompressobj().decompress(elements, 8)
                    unpacked += struct.unpack(f"{order}II", stated)[1]
                require_unpackable(unpacked, path, "bytes")


def _columns_of(name: str, value: object) -> dict[str, tuple[Column, str]]:
    """Return a variable's columns with units: one of a vector or a channel, several of a matrix."""
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
    """Return whether a variable is a cell array of others or an object, not numbers or texts."""
    if isinstance(value, np.ndarray) and value.dtype.kind != "O":
        return value.dtype.kind not in "fiubUS"
    cells = value if isinstance(value, list) else np.ravel(np.asarray(value, dtype=object))
    return any(not isinstance(cell, str | float | int | np.number | np.bool_) for cell in cells)


def _vector(name: str, value: object) -> Column:
    array = np.atleast_1d(np.atleast_1d(np.asarray(value)).squeeze())
    if array.ndim != 1:
        raise BadInputError(
            f"variable {name!r} has shape {array.shape}; a column of a log is a vector: save it as "
            "one, or leave it out"
        )
    return np.char.rstrip(array) if array.dtype.kind == "U" else array


def write_mat(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write one column vector a variable, and the header as text."""
    from scipy.io import savemat

    variables = {_HEADER: tomli_w.dumps(header), **columns}
    savemat(path, variables, appendmat=False, do_compression=True, oned_as="column")
