"""What long work says on standard error: a bar on a terminal, else a line now and then."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

Step = Callable[[], None]

_EVERY = 20.0  # s between two lines


@contextmanager
def progress(label: str, total: int) -> Iterator[Step]:
    """Show a progress bar and give the function that advances it.

    No bar without a label; no terminal on stderr gets a line instead, every 20 s at most.
    """
    if not label:
        yield lambda: None
        return
    if not sys.stderr.isatty():
        done, said = 0, monotonic()

        def advance() -> None:
            nonlocal done, said
            done += 1
            if monotonic() - said >= _EVERY:
                said = monotonic()
                say(f"{label}: {done:,} of {total:,}")

        yield advance
        return
    bar, line = terminal_bar(label, total)
    with bar:
        yield lambda: bar.advance(line)


def terminal_bar(label: str, total: int) -> tuple["Progress", "TaskID"]:
    """Return a bar for a terminal, to be shown as a context, and its line."""
    from rich.console import Console  # slow to load, and only a terminal needs it
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    return bar, bar.add_task(label, total=total)


def say(text: str) -> None:
    """Write a line to standard error."""
    from pitotbench.show.columns import printable

    sys.stderr.write(f"pitotbench: {printable(text)}\n")
    sys.stderr.flush()
