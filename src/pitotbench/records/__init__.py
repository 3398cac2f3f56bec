"""The records that packages exchange, and what all share: errors, checks, accuracies, views.

Views are those in a notebook.
"""

from collections.abc import Iterable
from importlib import import_module
from typing import TYPE_CHECKING, Any, cast

from pitotbench.catalog import UnknownNameError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from pandas import DataFrame


class BadInputError(ValueError):
    """The input cannot be used. The command line ends with exit code 2."""


class NoAnswerError(RuntimeError):
    """The input is valid but does not determine an answer.

    The answer is not observable, or the fit has not converged. Exit code 3.
    """


class OneHeadingError(NoAnswerError):
    """All headings are alike: the wind along them and the curve's level are one unknown."""


class UndeterminedError(NoAnswerError):
    """The fit has no usable bound, by what was flown, or as air data and GPS disagree."""


def error_words(error: BaseException) -> str:
    """Return the words of an error for a person: its message, where it is one of ours."""
    from numpy.linalg import LinAlgError  # NumPy takes longer to load than all the rest

    match error:
        case BadInputError() | NoAnswerError() | UnknownNameError():
            return str(error)
        case OSError():
            return f"{error.filename or 'file'}: {error.strerror or error}"
        case LinAlgError() | ArithmeticError():
            return (
                "the log does not determine an answer: the numbers leave the range of the "
                "computation; check its clock and its units"
            )
        case MemoryError():
            return "the memory does not suffice; check the clock of the log, or cut the log"
        case RecursionError():
            return "the input is nested too deeply; write it with fewer levels"
    text = " ".join(str(error).split()) or type(error).__name__
    return f"unexpected: {type(error).__name__}: {text}"


# The usual accuracies: 2σ of constant errors of the sensors, which hold where no log, mapping or
# flag states them. The bounds of a calibration, the reading of displays and the help text follow.
# Temperature: a calibrated total-temperature probe with its installation. Recovery factor: the
# spread between probes of one type. Static pressure: an air-data transducer. GPS velocity: a
# receiver without corrections.

USUAL_ACCURACIES: dict[str, float] = {
    "temperature_k": 1.5,
    "recovery_factor": 0.02,
    "static_pressure_pa": 30.0,
    "velocity_mps": 0.05,  # of each horizontal component
    "total_source": 0.01,  # of the impact pressure, of a pitot tube
}

SEARCH_FLIGHTS = 30  # by which `plan` improves the best card


_VIEWS = "pitotbench.show.notebook"  # by name, as the table of commands names its modules


class Shown:
    """A record that a notebook shows: as a line, as HTML, as a picture and as a table.

    The records know nothing of drawing: `show.notebook` holds the views, and is loaded when a view
    is first asked for.
    """

    __slots__ = ()

    def to_frame(self) -> "DataFrame":
        """Return the record as a table; each column ends in its unit."""
        return cast("DataFrame", views().to_frame(self))

    def plot(self, axes: Any = None) -> Any:
        """Draw the record on matplotlib's axes, or in a new figure; return the figure."""
        return views().plot(self, axes)

    def _repr_html_(self) -> str:
        return str(views().to_html(self))

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {views().in_one_line(self)}>"


def views() -> Any:
    """Return the module that shows and writes records."""
    return import_module(_VIEWS)


class RecordError(BadInputError):
    """The arrays of a record do not fit together. The message names the field and the rule."""


def freeze(array: "NDArray[np.generic]") -> "NDArray[np.generic]":
    """Return the array read-only, copied only if it views memory that others can still write."""
    import numpy as np  # only here: it takes longer to load than all that `--help` needs

    # A read-only view does not protect against a write through the array that it views.
    if array.flags.writeable or array.base is not None:
        array = np.ascontiguousarray(array) if array.base is None else array.copy()
        array.setflags(write=False)
    return array


def check_lengths(
    record: str, fields: "Iterable[tuple[str, NDArray[np.generic]]]", length: int
) -> None:
    """Raise RecordError where an array is not of shape (length,)."""
    for name, array in fields:
        if array.shape != (length,):
            raise RecordError(
                f"{record}.{name} has shape {array.shape}; every array of a {record} has {length} "
                "samples"
            )


def freeze_arrays(record: Any, length: int, *others: str) -> None:
    """Make the arrays of a record read-only. `others` are fields with a length of their own.

    Raises RecordError where another array is not of shape (length,).
    """
    from dataclasses import fields  # as slow to load as NumPy

    import numpy as np

    arrays = {f.name: getattr(record, f.name) for f in fields(record)}
    arrays = {name: each for name, each in arrays.items() if isinstance(each, np.ndarray)}
    lines = ((name, each) for name, each in arrays.items() if name not in others)
    check_lengths(type(record).__name__, lines, length)
    for name, array in arrays.items():
        object.__setattr__(record, name, freeze(array))
