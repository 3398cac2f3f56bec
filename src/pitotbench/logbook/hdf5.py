"""Read the variables of a .mat file of version 7.3, which is HDF5. Needs h5py, of the extra
pitotbench[hdf5].
"""

from pathlib import Path
from typing import Any

import numpy as np

from pitotbench.logbook.damage import AGAIN, require_unpackable
from pitotbench.records import BadInputError

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_USER_BLOCK = 512  # bytes of text that MATLAB puts before the HDF5 file
_CHARACTERS = b"char"
_NUMBER = np.dtype(np.float64).itemsize  # bytes
_TEXTS = 100  # rows of text that are read at a time


def is_hdf5(path: Path) -> bool:
    """Return whether a .mat file is of version 7.3."""
    with path.open("rb") as file:
        begin = file.read(_USER_BLOCK + len(_SIGNATURE))
    return begin.startswith(_SIGNATURE) or begin[_USER_BLOCK:] == _SIGNATURE


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
            return _Reading(path, file).fields(file)
    except BadInputError:
        raise
    except Exception as error:  # h5py lets OS, key and runtime errors out of a broken file
        raise BadInputError(f"not a complete .mat file of version 7.3{AGAIN}") from error


class _Reading:
    """Reads the objects of a file, each once, while they fit into the memory."""

    def __init__(self, path: Path, file: Any) -> None:
        self._path, self._seen = path, {file}
        self._bytes = 0.0  # of what was read

    def fields(self, group: Any) -> dict[str, Any]:
        """Return what a group itself holds: a link of another kind may lead into another file."""
        import h5py

        names = [name for name in group if not name.startswith("#")]
        return {
            name: self._value(group[name])
            for name in names
            if isinstance(group.get(name, getlink=True), h5py.HardLink)
        }

    def _value(self, item: Any) -> Any:
        """Return the value of a dataset, or of a group (a struct) by field."""
        if item in self._seen:  # groups within themselves, or one by a million names
            raise BadInputError(f"{item.name!r} is there by two names; save each variable once")
        self._seen.add(item)
        if hasattr(item, "items"):
            return self.fields(item)
        if item.external or item.is_virtual:
            raise BadInputError(f"{item.name!r} lies in another file; save the variables in one")
        found = self._read(item)
        array = np.asarray(found)
        if item.attrs.get("MATLAB_class", b"") == _CHARACTERS:
            return "".join(map(chr, array.ravel()))
        if array.dtype.kind in "SO" and array.ndim == 0:
            return (
                found.decode("utf-8", errors="replace") if isinstance(found, bytes) else str(found)
            )
        return array.T  # MATLAB stores column by column

    def _read(self, item: Any) -> Any:
        """Return the content of a dataset."""
        import h5py

        self._require_room(item.size * max(item.dtype.itemsize, _NUMBER))
        text = h5py.check_string_dtype(item.dtype)
        if text is None and (
            h5py.check_vlen_dtype(item.dtype) or (item.dtype.names and item.dtype.hasobject)
        ):
            raise BadInputError(f"{item.name!r} holds lists; save each channel as a vector")
        if text is None or text.length is not None or not item.ndim:
            return item[()]
        rows = list[Any]()  # texts of any length, which many rows may share in the file
        for begin in range(0, len(item), _TEXTS):
            rows += (part := item[begin : begin + _TEXTS]).tolist()
            self._require_room(sum(map(len, part.ravel())))
        return np.array(rows, dtype=object)

    def _require_room(self, size: float) -> None:
        self._bytes += size
        require_unpackable(self._bytes / _NUMBER, self._path)
