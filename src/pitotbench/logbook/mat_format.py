"""Read and write MATLAB files, version 5: one variable a column (or one struct of them), the header as text."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pitotbench.logbook.header import parse_header
from pitotbench.logbook.table import Column, Table
from pitotbench.records.errors import BadInputError
from pitotbench.records.toml_text import write_toml

_HEADER = "header"


def read_mat(path: Path) -> Table:
    """Read the vectors of a version 5 .mat file, or of the only struct in it.

    Raises BadInputError for a file that is not such a file, is cut off, is of version 7.3 (HDF5), or holds vectors
    of different lengths.
    """
    variables = {k: v for k, v in _load(path).items() if not k.startswith("__")}
    # MATLAB users often save one struct with a field a channel instead of many variables.
    structs = [v for v in variables.values() if isinstance(v, dict)]
    if len(structs) == 1:
        variables = {_HEADER: variables.get(_HEADER, ""), **structs[0]}
    stored = variables.pop(_HEADER, "")
    header, warnings = parse_header(stored if isinstance(stored, str) else "")
    columns = {name: _vector(name, value) for name, value in variables.items()}
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) > 1:
        listing = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise BadInputError(f"the variables differ in length ({listing}); keep one row a sample")
    return Table(tuple(columns), tuple(columns.values()), header, tuple(warnings))


def _load(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    try:
        found: dict[str, Any] = loadmat(path, simplify_cells=True)
        return found
    except NotImplementedError as error:
        raise BadInputError("a .mat file of version 7.3 (HDF5); save it with: save('log.mat', '-v7')") from error
    except Exception as error:  # SciPy's reader lets struct, zlib, index and type errors out of a broken file
        raise BadInputError(f"not a complete .mat file of version 5: {error}") from error


def _vector(name: str, value: object) -> Column:
    array = np.atleast_1d(np.asarray(value)).squeeze()
    if array.ndim != 1:
        raise BadInputError(f"variable {name!r} has shape {array.shape}; a column of a log is a vector")
    return np.char.rstrip(array) if array.dtype.kind == "U" else array


def write_mat(path: Path, columns: Mapping[str, Column], header: Mapping[str, Any]) -> None:
    """Write one column vector a variable, and the header as text."""
    from scipy.io import savemat

    variables = {_HEADER: write_toml(header), **columns}
    savemat(path, variables, appendmat=False, do_compression=True, oned_as="column")
