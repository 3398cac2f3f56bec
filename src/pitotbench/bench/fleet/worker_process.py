"""The process that performs tasks for a driver, and ends with it."""

import ctypes
import faulthandler
import os
import signal
import sys
from contextlib import suppress
from multiprocessing import parent_process
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from threading import Thread
from typing import Any

BEGUN = b""
_END_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)


def serve(calls: "Connection[Any, Any]", log: "Connection[Any, Any]", parent: int) -> None:
    """Perform the calls that arrive, one after the other, and send each result. End with the driver or at None.

    Everything that the process writes goes to `log`. `BEGUN` is sent when a call begins, then its result as
    (true, value) or its error as (false, error).
    """
    _end_with(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to the whole group; the driver ends its workers
    for stream in (1, 2):
        os.dup2(log.fileno(), stream)
    faulthandler.enable(file=2)
    with suppress(EOFError, OSError):  # the driver is gone
        while True:
            call = calls.recv_bytes()
            if not call:
                return
            calls.send_bytes(_answer(call, calls))
            sys.stdout.flush()


def _answer(call: bytes, calls: "Connection[Any, Any]") -> bytes:
    try:
        function, arguments, settings = ForkingPickler.loads(call)
        calls.send_bytes(BEGUN)  # the modules are loaded: the time of the call begins
        return bytes(ForkingPickler.dumps((True, function(*arguments, **settings))))
    except Exception as error:
        return _error(error)


def _error(error: Exception) -> bytes:
    try:
        text = bytes(ForkingPickler.dumps((False, error)))
        ForkingPickler.loads(text)
        return text
    except Exception:  # an error that cannot be sent, or not be rebuilt
        return bytes(ForkingPickler.dumps((False, RuntimeError(f"{type(error).__name__}: {error}"))))


def _end_with(parent: int) -> None:
    """Make this process end with its parent, whatever either is doing."""
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_END_WITH_PARENT, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:  # the parent ended before
        os._exit(1)
    # For the other systems, and for a parent thread that Linux does not tell from a parent.
    Thread(target=_wait_for_end_of_parent, daemon=True).start()


def _wait_for_end_of_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
