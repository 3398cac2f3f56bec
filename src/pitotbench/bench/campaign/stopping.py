"""Stop a campaign in order when the system or the user asks for it."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from types import FrameType

_ASKED = tuple(number for name in ("SIGTERM", "SIGHUP") if (number := getattr(signal, name, None)) is not None)


class StoppedError(KeyboardInterrupt):
    """A campaign was asked to stop. Its message says what is stored and how to go on."""


@contextmanager
def stoppable() -> Iterator[None]:
    """Let SIGTERM and SIGHUP raise KeyboardInterrupt as Ctrl-C does, so that all is closed in order."""
    if current_thread() is not main_thread():  # only the main thread may set handlers
        yield
        return
    before = {number: signal.signal(number, _stop) for number in _ASKED}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _stop(number: int, _: FrameType | None) -> None:
    raise KeyboardInterrupt(signal.Signals(number).name)
