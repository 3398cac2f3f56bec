"""Read and write MATLAB files: one variable a column (or one struct, or one matrix of them), the header as text.

Files of version 7.3 are HDF5; `mat73_format` reads them. Written are files of version 5.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from pitotbench.logbook.header import parse_header
from pitotbench.logbook.mat73_format import is_hdf5, load_hdf5
from pitotbench.logbook.table import Column, Table
from pitotbench.records.errors import BadInputError

_HEADER = "header"
_DATA, _UNITS = "data", ("units", "unit")  # fields of a struct that is one channel


def read_mat(path: Path) -> Table:
    """Read the vectors of a .mat file, or of the only struct in it.

    A matrix with a row a sample, such as `fdata` of SIDPAC, gives the columns `fdata(:,1)`, `fdata(:,2)`, ... A
    struct with a field `data` (and `units`) is one channel. Single numbers and texts beside the vectors are left
    out. Raises BadInputError for a file that is not such a file, is cut off, or holds vectors of different lengths.
    """
    variables = {k: v for k, v in _load(path).items() if not k.startswith("__")}
    # MATLAB users often save one struct with a field a channel instead of many variables.
    structs = [v for v in variables.values() if isinstance(v, dict) and _DATA not in v]
    if len(structs) == 1:
        variables = {_HEADER: variables.get(_HEADER, ""), **structs[0]}
    stored = variables.pop(_HEADER, "")
    header, warnings = parse_header(stored if isinstance(stored, str) else "")
    found: dict[str, tuple[Column, str]] = {}
    for name, value in variables.items():
        found |= _columns_of(name, value)
    vectors = {name: pair for name, pair in found.items() if len(pair[0]) > 1} or found
    lengths = {name: len(column) for name, (column, _) in vectors.items()}
    if len(set(lengths.values())) > 1:
        listing = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise BadInputError(f"the variables differ in length ({listing}); keep one row a sample")
    columns, units = zip(*vectors.values(), strict=True) if vectors else ((), ())
    return Table(tuple(vectors), columns, header, tuple(warnings), units if any(units) else ())


def _load(path: Path) -> dict[str, Any]:
    if is_hdf5(path):
        return load_hdf5(path)
    from scipy.io import loadmat

    try:
        found: dict[str, Any] = loadmat(path, simplify_cells=True)
        return found
    except Exception as error:  # SciPy's reader lets struct, zlib, index and type errors out of a broken file
        raise BadInputError(f"not a complete .mat file: {error}") from error


def _columns_of(name: str, value: object) -> dict[str, tuple[Column, str]]:
    """Return the columns of a variable with their units: one of a vector or channel, several of a matrix."""
    if isinstance(value, dict):
        unit = next((str(value[key]) for key in _UNITS if key in value), "")
        return {name: (_vector(name, value[_DATA]), unit)} if _DATA in value else {}
    array = np.asarray(value)
    if array.ndim == 2 and min(array.shape) > 1 and array.dtype.kind in "fiu":
        return {f"{name}(:,{k + 1})": (array[:, k], "") for k in range(array.shape[1])}
    return {name: (_vector(name, value), "")}


def _vector(name: str, value: object) -> Column:
    array = np.atleast_1d(np.atleast_1d(np.asarray(value)).squeeze())
    if array.ndim != 1:
        raise BadInputError(f"variable {name!r} has shape {array.shape}; a column of a log is a vector")
    return np.char.rstrip(array) if array.dtype.kind == "U" else array


def write_mat(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write one column vector a variable, and the header as text."""
    from scipy.io import savemat

    variables = {_HEADER: tomli_w.dumps(header), **columns}
    savemat(path, variables, appendmat=False, do_compression=True, oned_as="column")
