"""Limits of what others wrote: packed files, and TOML by size, depth and dots of keys."""

import tomllib
from pathlib import Path
from typing import Any

from pitotbench.records import BadInputError

MOST_UNPACKED = 400 << 20  # bytes of a packed log: a day at 10 Hz in text
_MOST_DOTS = 50_000_000  # of their squares: some 200 MB while the text is read
_MOST_TOML = 16 << 20  # bytes of a file: a plan of 300,000 flights, one by one


def toml_table(text: str) -> dict[str, Any]:
    """Return the table of TOML text.

    Raises ValueError for text that is not TOML or takes too long to read.

    The reader's time and memory grow with the square of the dots in a key, which stands on one
    line.
    """
    if sum(line.count(".") ** 2 for line in text.splitlines()) > _MOST_DOTS:
        raise ValueError("a key has too many dots")
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise ValueError("nested too deeply") from error


def toml_text(path: Path, what: str) -> str:
    """Return the text of a TOML file; `what` it is stands in the message of an error.

    Raises BadInputError that begins with the path where the file cannot be read, is too large or is
    no text.
    """
    try:
        require_regular(path)
        if path.stat().st_size > _MOST_TOML:
            raise ValueError(f"it is larger than {_MOST_TOML >> 20} MB")
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise BadInputError(
            f"{path}: cannot be read as {what}: {error.strerror or error}"
        ) from error
    except UnicodeDecodeError as error:
        raise BadInputError(f"{path}: not UTF-8 text; {what} is a TOML file") from error
    except ValueError as error:
        raise BadInputError(f"{path}: cannot be read as {what}: {error}") from error


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """Return the table of a TOML file.

    Raises BadInputError as `toml_text` does, and for text that is no TOML.
    """
    text = toml_text(path, what)
    try:
        return toml_table(text)
    except ValueError as error:  # or a number of thousands of digits
        raise BadInputError(f"{path}: not valid TOML: {error}") from error


def require_regular(path: Path) -> None:
    """Raise BadInputError for a pipe or a device: it may give nothing, or never end."""
    if path.exists() and not path.is_file():
        raise BadInputError("not a regular file; copy what it gives into a file first")
