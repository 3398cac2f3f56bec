"""Why a task gave no result, in words."""

from collections.abc import Sequence
from dataclasses import dataclass
from traceback import format_exception
from typing import TypeVar

from pitotbench.catalog import UnknownNameError
from pitotbench.records.errors import BadInputError, NoAnswerError

R = TypeVar("R")

_EXPECTED = (BadInputError, NoAnswerError, UnknownNameError)


class LostWorkError(RuntimeError):
    """The process that performed a task has ended. `log` is the last part of what the process wrote."""

    def __init__(self, reason: str, log: str = "") -> None:
        super().__init__(reason)
        self.log = log


class FleetLostError(RuntimeError):
    """The executor cannot be used any longer; another one can perform the tasks that are not done."""


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a task gave no result, in words.

    `kind` is the type of the error that `require_all` raises for it. `trace` is the traceback, or the last lines of
    the log of a process that died; it is empty for an error that the bench expects. `quarantined` is true for a
    task that ended its process, or that broke the limits of time or memory.
    """

    reason: str
    kind: type[Exception] = RuntimeError
    trace: str = ""
    quarantined: bool = False

    @classmethod
    def of(cls, error: BaseException) -> "Failure":
        """Return the failure that describes an error. It names the type of an error that the bench does not expect.

        The error itself is not kept, because not every error can be sent from one process to another.
        """
        for kind in _EXPECTED:
            if isinstance(error, kind):
                return cls(str(error), kind)
        return cls(f"{type(error).__name__}: {error}", trace="".join(format_exception(error)))


def require_all(results: Sequence[R | Failure]) -> list[R]:
    """Return the results. Where a task failed, raise the first failure as an error of its kind instead."""
    for result in results:
        if isinstance(result, Failure):
            raise result.kind(f"{result.reason}\n{result.trace}".rstrip())
    return [result for result in results if not isinstance(result, Failure)]
