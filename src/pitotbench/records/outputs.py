"""The places where a command will write, checked before its work begins.

Files are written whole or not at all. An output is never one of the inputs.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from os.path import abspath
from pathlib import Path
from tempfile import TemporaryFile, gettempdir
from typing import TYPE_CHECKING
from uuid import uuid4

from pitotbench.records import BadInputError

if TYPE_CHECKING:
    import sqlite3

PAGES = (".html", ".htm")


def file_name(path: Path | str) -> str:
    """Return the name of a file or folder; of `.` and `..` that of the folder they stand for."""
    return Path(abspath(path)).name


def require_file(path: Path, suffixes: Iterable[str], inputs: Iterable[Path] = ()) -> None:
    """Raise BadInputError unless a file can be written to `path`.

    The suffix must be one of `suffixes`, the path none of the `inputs`, its folder must exist and
    be writable, and `path` must not be a folder or a device.
    """
    known = tuple(suffixes)
    if path.is_dir():
        raise BadInputError(
            f"{path}: a folder; name a file in it that ends in {' or '.join(known)}"
        )
    if path.suffix.lower() not in known:
        raise BadInputError(f"{path}: the name must end in {' or '.join(known)}")
    _require_no_input(path, inputs)
    if path.exists() and not path.is_file():
        raise BadInputError(
            f"{path}: not a regular file, so it cannot be replaced; choose another name"
        )
    if not path.parent.is_dir():
        raise BadInputError(
            f"{path}: the folder {path.parent} does not exist; make it or choose another"
        )
    _require_takes_files(path.parent, path)


def require_folder(path: Path, names: Iterable[str] = (), inputs: Iterable[Path] = ()) -> None:
    """Raise BadInputError unless files can be written to `path`, a folder that need not exist.

    `names` are the files that will be written there; none of them may be one of the `inputs`.
    """
    inputs = tuple(inputs)
    for name in names:
        _require_no_input(path / name, inputs)
        if (path / name).is_dir():
            raise BadInputError(
                f"{path / name}: a folder where a file is to be written; choose another folder"
            )
    nearest = next(place for place in (path, *path.absolute().parents) if place.exists())
    if not nearest.is_dir():
        raise BadInputError(f"{path}: {nearest} is a file, not a folder; choose another folder")
    _require_takes_files(nearest, path)


def _require_no_input(path: Path, inputs: Iterable[Path]) -> None:
    for source in inputs:
        if path.resolve() == source.resolve() or (
            path.exists() and source.exists() and path.samefile(source)
        ):
            raise BadInputError(
                f"{path}: this is an input and would be overwritten; choose another name"
            )


def _require_takes_files(folder: Path, path: Path) -> None:
    """Raise BadInputError where a folder cannot take files."""
    # Only an attempt shows it: permissions say nothing for an administrator, or on a read-only or
    # virtual disk.
    try:
        with TemporaryFile(dir=folder):
            pass
    except OSError as error:
        reason = error.strerror or error
        raise BadInputError(
            f"{path}: cannot be written: {reason}; choose another folder"
        ) from error


def lock(path: Path, wait: float = 0.0) -> "sqlite3.Connection":
    """Take the lock of a file, which is made, and hold it until the connection is closed.

    The lock ends with this process too, however that ends. Raises sqlite3.Error where another holds
    it for `wait` [s].
    """
    import sqlite3  # loads with the first lock

    held = sqlite3.connect(path, timeout=wait, isolation_level=None)
    try:
        held.execute("BEGIN IMMEDIATE")  # nothing is ever written: a full disk can be locked too
    except sqlite3.Error:
        held.close()
        raise
    return held


@contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """Give a temporary path beside `path`; rename it to `path` on success, else remove it.

    A reader therefore never finds half a file. A device or a pipe, such as /dev/null, is written
    into. Raises BadInputError where the folder does not exist or cannot be written.
    """
    written_into = path.exists() and not path.is_file()
    folder = Path(gettempdir()) if written_into else path.parent
    # The random part of the name keeps two processes that write the same file apart.
    temporary = folder / f".{path.name}.{uuid4().hex[:8]}.part"
    try:
        yield temporary
        if written_into:
            path.write_bytes(temporary.read_bytes())
        else:
            temporary.replace(path)
    except OSError as error:
        raise BadInputError(
            f"{path}: cannot be written: {error.strerror or error}; choose another folder"
        ) from error
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file whole or not at all. Raises BadInputError as `atomic` does."""
    with atomic(path) as scratch:  # "replace": a file name from the disk may not be UTF-8
        scratch.write_text(text, encoding="utf-8", errors="replace")
