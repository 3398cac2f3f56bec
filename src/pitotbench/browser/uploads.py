"""Files that come through the page: streamed into a private folder, under names that we give."""

import sqlite3
from contextlib import suppress
from http import HTTPStatus
from itertools import count
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory
from urllib.parse import unquote

from tornado.web import HTTPError, RequestHandler, stream_request_body

from pitotbench.logbook.bundle import ZIP
from pitotbench.logbook.formats import FORMATS, READ_ONLY, TOPIC_READERS
from pitotbench.logbook.mapping import find_mapping, shipped
from pitotbench.records import BadInputError
from pitotbench.records.calibration_request import NamedFile
from pitotbench.records.outputs import lock

MOST_BYTES = 500 << 20  # of a file
ENDINGS = tuple(dict.fromkeys((*READ_ONLY, *FORMATS, *TOPIC_READERS, ZIP)))
_MOST_FILES = 10_000  # of one visit
_PREFIX, _LOCK, _FOLDER = "pitotbench-page-", "lock.sqlite", "own"
_SWEPT = 10.0  # s that another server may hold our lock, to see whether it is free
_LONGEST = 200  # letters of a name that are shown


class Store:
    """A private folder for files, one folder a drop, deleted at the end.

    The folder of a server that was killed, whose lock is free, is deleted when the next one starts.
    """

    def __init__(self) -> None:
        self._own = TemporaryDirectory(prefix=_PREFIX)  # only its owner may enter
        place = Path(self._own.name)
        try:
            self._lock = lock(place / _LOCK, wait=_SWEPT)
        except sqlite3.Error as error:
            raise BadInputError(
                f"{place}: {error}; set TMPDIR to a folder that can be locked"
            ) from error
        _sweep(place)
        self._drops: dict[str, Path] = {}  # their folders
        self.known: list[NamedFile] = []
        self._numbers = count(1)

    def new_path(self, name: str, drop: str) -> Path | None:
        """Return where to put a file of a drop by the user's name of it, None if it is not taken.

        A file that can be no log is not taken, nor one too many. The name on the disk is ours. Its
        ending is one of the known ones; a file that belongs to a log in several files keeps the
        ending by which its mapping finds it.
        """
        ending, number = ending_of(name), next(self._numbers)
        if not ending or number > _MOST_FILES:
            return None
        folder = self._drops.setdefault(drop, self.new_folder())
        folder.mkdir(exist_ok=True)
        path = folder / f"log{ending}"
        if ending[0] == "." or path.exists():
            path = folder / f"log{number}{ending}"
        self.known.append(NamedFile(path, shown_name(name)))
        return path

    def names(self, drop: str) -> dict[Path, str]:
        """Return the files of a drop, with the names by which the user knows them."""
        return {
            each.path: each.name
            for each in self.known
            if each.path.parent == self._drops.get(drop) and each.path.exists()
        }

    def named(self, words: str) -> str:
        """Return words with the names that the user knows in place of the paths."""
        for each in sorted(self.known, key=lambda file: -len(str(file.path))):
            words = words.replace(str(each.path), each.name)
        return words

    def new_folder(self) -> Path:
        """Return a folder that does not exist yet."""
        return Path(self._own.name) / f"{_FOLDER}{next(self._numbers)}"

    def write(self, name: str, text: str) -> NamedFile:
        """Write a text of ours, such as a mapping, under a name of ours."""
        folder = self.new_folder()
        folder.mkdir()
        (folder / name).write_text(text, encoding="utf-8")
        self.known.append(NamedFile(folder / name, name))
        return self.known[-1]

    def close(self) -> None:
        """Delete the folder."""
        self._lock.close()
        self._own.cleanup()


def _sweep(own: Path) -> None:
    """Delete the folders beside ours that hold files and whose lock is free.

    A server writes no file before it holds its lock.
    """
    for file in own.parent.glob(f"{_PREFIX}*/{_LOCK}"):
        folder = file.parent
        with suppress(OSError, sqlite3.Error):
            if folder.lstat().st_uid == own.stat().st_uid and [*folder.glob(f"{_FOLDER}*")]:
                lock(file).close()
                rmtree(folder)


def ending_of(name: str) -> str:
    """Return the ending of a file's name that is known, empty where none is."""
    low = name.lower()
    parts = [
        pattern.removeprefix("*")
        for mapping in map(find_mapping, shipped())
        if len(mapping.files) > 1
        for file in mapping.files
        for pattern in file.patterns
    ]
    known = [*sorted(parts, key=len, reverse=True), "PARM.csv", *ENDINGS]
    return next((each for each in known if low.endswith(each.lower())), "")


def shown_name(name: str) -> str:
    """Return a file's name for display and commands, without control codes and paths elsewhere."""
    parts = [part for part in name.replace("\\", "/").split("/") if part not in ("", ".", "..")]
    return "".join(letter for letter in "/".join(parts) if letter.isprintable())[-_LONGEST:]


@stream_request_body
class Upload(RequestHandler):
    """Takes one file, as the body of a request. The gate has looked at the cookie before."""

    _path: Path | None = None

    def prepare(self) -> None:
        """Refuse a body that is too large, or is no log, before it is read."""
        headers, most = self.request.headers, self.settings["most"]
        # Without a stated length nothing is taken; of a stated one Tornado reads no byte more.
        length = headers.get("Content-Length", "")
        if not length.isdecimal() or len(length) > len(str(most)) or int(length) > most:
            raise HTTPError(
                HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
                reason=f"more than {most >> 20:,} MB: cut the log",
            )
        self._path = self.settings["desk"].store.new_path(
            unquote(headers.get("X-Name", "")), headers.get("X-Drop", "")
        )
        if self._path is None:
            raise HTTPError(
                HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
                reason=f"no log: a log ends in {', '.join(ENDINGS)}",
            )
        self.request.connection.set_max_body_size(most)  # type: ignore[union-attr]
        self._file = self._path.open("wb")

    def data_received(self, chunk: bytes) -> None:
        """Write what came."""
        self._file.write(chunk)

    def post(self) -> None:
        """Close the file. The page tells when all of a drop have arrived."""
        self._file.close()

    def on_connection_close(self) -> None:
        """Delete what came of a file that is broken off."""
        if self._path is not None and not self._file.closed:
            self._file.close()
            self._path.unlink()
