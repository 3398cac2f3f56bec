"""What is said of files that are damaged, cut off, or unpack to more than the memory holds."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryFile

from pitotbench.records import BadInputError

# What a reader of a library says of a broken file is of its own workings, not of the file.
AGAIN = ": it is damaged or cut off; copy it again from its source"

# A compressed file may unpack to far more than the memory holds. Its own metadata tell how much,
# before it is read.
NUMBER = 8  # bytes of a value
_MANY = 50_000_000  # values
_DENSEST = 100  # values a byte, of which a recorder's file holds less than ten


def require_unpackable(values: float, path: Path, kind: str = "numbers") -> None:
    """Raise BadInputError for a file that unpacks to far more values than a recorder writes.

    The limit grows with the bytes of the file.
    """
    size = path.stat().st_size
    most = max(_MANY, _DENSEST * size)
    if values > most:
        raise BadInputError(
            f"{size:,} bytes would unpack to {values:,.0f} {kind}, where {most:,} are the most for "
            "a file of this size: no recorder writes such a file; write the rows of the log again"
        )


@contextmanager
def complete(kind: str, broken: type[Exception] | tuple[type[Exception], ...]) -> Iterator[None]:
    """Raise BadInputError for what a library raises of a file of a kind that is `broken`."""
    try:
        yield
    except BadInputError:
        raise
    except broken as error:
        raise BadInputError(f"not a complete {kind}{AGAIN}") from error


@contextmanager
def heard(said: list[str]) -> Iterator[None]:
    """Keep the lines that a library prints of what it skips, those of its compiled part as well.

    The compiled part writes to the descriptor itself.
    """
    with TemporaryFile() as file, redirect_stdout(StringIO()) as printed, redirect_stderr(printed):
        own = os.dup(2)
        os.dup2(file.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(own, 2)
            os.close(own)
            file.seek(0)
            said += (
                printed.getvalue() + file.read().decode("utf-8", errors="replace")
            ).splitlines()


def damage(library: str, lines: list[str], broken: bool) -> tuple[str, ...]:
    """Return warnings of what a library printed of damage, and of a last message cut off."""
    more = f" and {len(lines) - 1:,} more remarks" if len(lines) > 1 else ""
    sentences = (
        [f"the file is damaged, rows may be missing ({library}: {lines[0]}{more})"] if lines else []
    )
    return (
        *sentences,
        *(["the last message of the log breaks off: its end is missing"] if broken else []),
    )
