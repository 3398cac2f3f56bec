"""Folders and .zip files, such as a display's card: which logs they hold, and which flights."""

import lzma
import stat
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

from pitotbench.logbook.columns import within
from pitotbench.logbook.formats import FORMATS, READ_ONLY, TOPIC_READERS
from pitotbench.logbook.mapping import find_mapping, shipped
from pitotbench.records import BadInputError
from pitotbench.records.intake import MOST_UNPACKED

ZIP = ".zip"
_MOST_BYTES = 2 << 30  # of an unpacked .zip: more fits no card's month of flights
_MOST_FILES = 500  # of a folder that are read
_MOST_MEMBERS = 10_000  # of a .zip
# What a file that is cut or changed raises.
_BROKEN = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError)


def is_bundle(path: Path) -> bool:
    """Return whether a path is a folder or a .zip file."""
    return path.is_dir() or (path.suffix.lower() == ZIP and path.is_file())


@contextmanager
def opened(path: Path) -> Iterator[Path]:
    """Give the path at which a log can be read, inside a .zip file that of an unpacked folder.

    A path is a log's own, a .zip file's, or one in it (`card.zip/flight.csv`). The folder is
    removed again. Raises BadInputError for a .zip file that is broken, locked, or unpacks to more
    than 2 GB, and where the disk does not take it.
    """
    packed = next(
        (p for p in (path, *path.parents) if p.suffix.lower() == ZIP and p.is_file()), None
    )
    if packed is None:
        yield path
        return
    with TemporaryDirectory() as folder:
        unpack(packed, Path(folder))
        yield Path(folder) / path.relative_to(packed)


def unpack(packed: Path, folder: Path) -> None:
    """Unpack a .zip file into a folder.

    Raises BadInputError for one that is broken, locked, holds more than 10,000 members, a link or a
    way out of the folder, or unpacks to more than 2 GB, and where the disk does not take it.
    """
    try:
        with zipfile.ZipFile(packed) as file:
            members = file.infolist()
            size = sum(entry.file_size for entry in members)
            if size > _MOST_BYTES:
                raise BadInputError(
                    f"it unpacks to {size >> 20:,} MB: unpack it, and give the logs alone"
                )
            if len(members) > _MOST_MEMBERS:
                raise BadInputError(
                    f"it holds {len(members):,} files, where {_MOST_MEMBERS:,} are the most: give "
                    "the logs alone"
                )
            for each in members:
                _require_harmless(each)
            file.extractall(folder)
    except OSError as error:
        raise BadInputError(
            f"cannot be unpacked: {error.strerror or error}; unpack it, and give the folder"
        ) from error
    # RuntimeError: a password, or a method of packing that is not known.
    # UnicodeError and IndexError: a name that is no text, or none.
    except (*_BROKEN, RuntimeError, UnicodeError, IndexError) as error:
        raise BadInputError(
            "not a complete .zip file, or one with a password: unpack it, and give the folder"
        ) from error


def _require_harmless(member: zipfile.ZipInfo) -> None:
    """Raise BadInputError for a member that is too large, a link, or outside of the folder."""
    if member.file_size > MOST_UNPACKED:
        raise BadInputError(
            f"its member {member.filename!r} unpacks to {member.file_size >> 20:,} MB, where "
            f"{MOST_UNPACKED >> 20} are the most: cut the log, and give the logs alone"
        )
    path = PurePosixPath(member.filename.replace("\\", "/"))
    link = stat.S_ISLNK(member.external_attr >> 16)  # the mode of Unix is in the upper half
    if link or path.is_absolute() or ".." in path.parts or ":" in str(path)[:2]:
        raise BadInputError(
            f"its member {member.filename!r} is a link or leads out of the folder: pack the logs "
            "alone"
        )


def logs_given(path: Path) -> list[Path]:
    """Return the paths at which the logs of a folder or of a .zip file are read, or a log's own.

    A log has its own path, and so has a bundle that holds one log.

    Raises as `opened` and `logs_in` do.
    """
    if not is_bundle(path):
        return [path]
    with within(path), opened(path) as folder:
        found = [path / each.relative_to(folder) for each in logs_in(folder)]
    return found if len(found) > 1 else [path]


def logs_in(folder: Path) -> list[Path]:
    """Return the files below a folder, at any depth, that may be logs by their names.

    Of a log in several files, as one table a topic, the first file of its mapping stands for all.
    Raises BadInputError for a folder of more than 500 such files.
    """
    suffixes = tuple({*FORMATS, *READ_ONLY, *TOPIC_READERS})
    files = sorted(
        path
        for path in folder.rglob("*")
        if path.name.lower().endswith(suffixes) and path.is_file() and path.name[0] not in "._"
    )
    if len(files) > _MOST_FILES:
        raise BadInputError(
            f"a folder of {len(files):,} logs, where {_MOST_FILES} are the most: give a part of it"
        )
    parts: set[Path] = set()
    for entries in (find_mapping(name).files for name in shipped()):
        lead, *others = [pattern for entry in entries for pattern in entry.patterns] or [""]
        for first in files if others else ():
            if first.match(lead):
                prefix = first.name.removesuffix(lead.removeprefix("*"))
                parts |= {first.with_name(p.replace("*", prefix)) for p in (*others, "*PARM.csv")}
                # A log of a table a topic holds topics that no mapping reads.
                parts |= {each for each in first.parent.glob(f"{prefix}*.csv") if prefix} - {first}
    return [path for path in files if path not in parts]
