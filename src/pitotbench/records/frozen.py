"""What every record with arrays does once built: one length for all, float64, read-only, no NaN unless allowed."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from pitotbench.records.errors import BadInputError


class RecordError(BadInputError):
    """The arrays of a record do not fit together; the message names the field and the rule."""


def freeze(array: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return the array read-only, copying only where it is a view of memory that others can still write."""
    if array.flags.writeable or array.base is not None:
        array = np.ascontiguousarray(array) if array.base is None else array.copy()
        array.setflags(write=False)
    return array


def check_lengths(record: str, fields: Iterable[tuple[str, NDArray[np.generic]]], length: int) -> None:
    """Raise `RecordError` where an array is not one-dimensional of the common length."""
    for name, array in fields:
        if array.shape != (length,):
            raise RecordError(
                f"{record}.{name} has shape {array.shape}; every array of a {record} has {length} samples"
            )
