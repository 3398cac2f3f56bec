"""Read the variables of a .mat file of version 7.3, which is HDF5.

Needs h5py, of the extra pitotbench[hdf5].
"""

from pathlib import Path
from typing import Any

import numpy as np

from pitotbench.logbook.damage import NUMBER, complete, require_unpackable
from pitotbench.records import BadInputError

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_USER_BLOCK = 512  # bytes of text that MATLAB puts before the HDF5 file
_CHARACTERS = b"char"


def is_hdf5(path: Path) -> bool:
    """Return whether a .mat file is of version 7.3."""
    with path.open("rb") as file:
        begin = file.read(_USER_BLOCK + len(_SIGNATURE))
    return begin.startswith(_SIGNATURE) or begin[_USER_BLOCK:] == _SIGNATURE


def load_hdf5(path: Path) -> dict[str, Any]:
    """Return a file's variables by name: arrays as MATLAB shows them, texts, structs as dicts.

    Raises BadInputError where h5py is not installed or the file is broken.
    """
    try:
        import h5py  # an extra: most users never read such a file
    except ImportError as error:
        raise BadInputError(
            "a .mat file of version 7.3 needs h5py: pip install 'pitotbench[hdf5]', or "
            "save('log.mat', '-v7')"
        ) from error
    # h5py lets OS, key and runtime errors out of a broken file.
    with complete(".mat file of version 7.3", Exception), h5py.File(path, "r") as file:
        sizes = [0]
        file.visititems(lambda _, item: sizes.append(getattr(item, "nbytes", 0)))
        require_unpackable(sum(sizes) / NUMBER, path)
        return _fields(file, h5py, {file})


def _fields(group: Any, h5py: Any, seen: set[Any]) -> dict[str, Any]:
    """Return what a group itself holds: a link of another kind may lead into another file.

    What was `seen` is not read again.
    """
    return {
        name: _value(group[name], h5py, seen)
        for name in group
        if not name.startswith("#") and isinstance(group.get(name, getlink=True), h5py.HardLink)
    }


def _value(item: Any, h5py: Any, seen: set[Any]) -> Any:
    """Return the value of a dataset, or of a group (a struct) by field."""
    if item in seen:  # a group within itself, or one thing by a million names
        raise BadInputError(f"{item.name!r} is there by two names; save each variable once")
    seen.add(item)
    if hasattr(item, "items"):
        return _fields(item, h5py, seen)
    if item.external or item.is_virtual:
        raise BadInputError(f"{item.name!r} lies in another file; save the variables in one")
    # The rows of a column of texts may be one text in the file, which then fills the memory.
    if item.ndim and item.dtype.hasobject and not h5py.check_ref_dtype(item.dtype):
        raise BadInputError(f"{item.name!r} holds texts or lists of any length; leave it out")
    found = item[()]
    array = np.asarray(found)
    if item.attrs.get("MATLAB_class", b"") == _CHARACTERS:
        return "".join(map(chr, array.ravel()))
    if array.dtype.kind in "SO" and array.ndim == 0:
        return found.decode("utf-8", errors="replace") if isinstance(found, bytes) else str(found)
    return array.T  # MATLAB stores column by column
