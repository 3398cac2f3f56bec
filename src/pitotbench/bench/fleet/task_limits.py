"""Limits of time and memory of one task, in the process that performs it."""

import faulthandler
import os
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from io import UnsupportedOperation

TIME_OVER = "Timeout ("  # how faulthandler begins its report


def _here() -> tuple[str, int]:
    return socket.gethostname(), os.getpid()


@dataclass(frozen=True, slots=True)
class Limits:
    """The most that one task may use: `seconds` of wall time and `memory` bytes of its process. None: no limit.

    They do not hold in the process of the driver, since a task that breaks the limit of time ends its process.
    """

    seconds: float | None = None
    memory: int | None = None
    driver: tuple[str, int] = field(default_factory=_here)

    @contextmanager
    def hold(self) -> Iterator[None]:
        """Hold the limits within the context.

        After the time the process writes where it is and ends. The memory is that of data (RLIMIT_DATA): an
        allocation above it raises MemoryError, or ends the process where a library does not expect that.
        """
        if self.driver == _here():
            yield
            return
        with _memory(self.memory), _time(self.seconds):
            yield


@contextmanager
def _time(seconds: float | None) -> Iterator[None]:
    if seconds is None:
        yield
        return
    # Its thread is not a thread of Python: it also ends a process that is stuck inside the simulator.
    faulthandler.dump_traceback_later(seconds, exit=True, file=_log())
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()


def _log() -> int:
    """Return the descriptor of standard error, also where `sys.stderr` is no file."""
    with suppress(AttributeError, OSError, UnsupportedOperation):
        return sys.stderr.fileno()
    return 2


@contextmanager
def _memory(most: int | None) -> Iterator[None]:
    try:
        import resource
    except ImportError:  # not a POSIX system: no limit
        yield
        return
    if most is None:
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    allowed = most if hard == resource.RLIM_INFINITY else min(most, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (allowed, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))
