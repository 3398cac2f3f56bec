"""Checks for records with arrays: all arrays have one length and become read-only."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from pitotbench.records.errors import BadInputError


class RecordError(BadInputError):
    """The arrays of a record do not fit together. The message names the field and the rule."""


def freeze(array: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return the array read-only; copy it only where it is a view of memory that others can still write."""
    # A read-only view does not protect against a write through the array that it views.
    if array.flags.writeable or array.base is not None:
        array = np.ascontiguousarray(array) if array.base is None else array.copy()
        array.setflags(write=False)
    return array


def check_lengths(record: str, fields: Iterable[tuple[str, NDArray[np.generic]]], length: int) -> None:
    """Raise RecordError where an array is not of shape (length,)."""
    for name, array in fields:
        if array.shape != (length,):
            raise RecordError(
                f"{record}.{name} has shape {array.shape}; every array of a {record} has {length} samples"
            )
