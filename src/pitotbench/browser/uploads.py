"""Files that come through the page: streamed into a private folder, under names that we give."""

from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import unquote

from tornado.httputil import HTTPServerRequest
from tornado.web import RequestHandler, stream_request_body

from pitotbench.browser.work import LogFile
from pitotbench.logbook.bundle import ZIP
from pitotbench.logbook.formats import FORMATS, READ_ONLY, TOPIC_READERS
from pitotbench.logbook.mapping import find_mapping, shipped

MOST_BYTES = 500 << 20  # of a file
_MOST_FILES = 10_000  # of one visit
_LONGEST = 200  # letters of a name that are shown
_TOO_LARGE = 413
_UNKNOWN = 415


class Store:
    """A private folder for files, one folder a drop. It is deleted at the end."""

    def __init__(self) -> None:
        self._own = TemporaryDirectory(prefix="pitotbench-")  # only its owner may enter
        self._drops: dict[str, dict[Path, str]] = {}
        self._count = 0

    def new_path(self, name: str, drop: str) -> Path:
        """Return where a file is to be put that the user knows by a name, in the folder of a drop.

        The name on the disk is ours. Its ending is one of the known ones; a file that belongs to a
        log in several files keeps the ending by which its mapping finds it. Raises ValueError, in
        words, for a file that can be no log.
        """
        ending = ending_of(name)
        if not ending:
            known = ", ".join(sorted({*FORMATS, *READ_ONLY, *TOPIC_READERS, ZIP}))
            raise ValueError(f"no log: the name of a log ends in {known}")
        if self._count >= _MOST_FILES:
            raise ValueError(f"{_MOST_FILES:,} files were dropped: start again")
        self._count += 1
        files = self._drops.setdefault(drop, {})
        folder = Path(self._own.name) / f"drop{list(self._drops).index(drop)}"
        folder.mkdir(exist_ok=True)
        number = "" if ending[0] != "." else f"{self._count:05}"
        path = folder / f"log{number}{ending}"
        if path.exists():  # a second set of files in one drop
            path = folder / f"{self._count:05}{ending}"
        files[path] = shown_name(name)
        return path

    def names(self, drop: str) -> dict[Path, str]:
        """Return the files of a drop, with the names by which the user knows them."""
        return dict(self._drops.get(drop, {}))

    def forget(self, path: Path, drop: str) -> None:
        """Delete a file that did not arrive whole."""
        path.unlink(missing_ok=True)
        self._drops.get(drop, {}).pop(path, None)

    def new_folder(self) -> Path:
        """Return a folder that does not exist yet."""
        self._count += 1
        return Path(self._own.name) / f"unpacked{self._count}"

    def write(self, name: str, text: str) -> LogFile:
        """Write a text of ours, such as a mapping, under a name of ours."""
        folder = self.new_folder()
        folder.mkdir()
        (folder / name).write_text(text, encoding="utf-8")
        return LogFile(folder / name, name)

    def close(self) -> None:
        """Delete the folder."""
        self._own.cleanup()


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
    known = [*sorted(parts, key=len, reverse=True), "PARM.csv", *READ_ONLY, *FORMATS]
    return next((e for e in [*known, *TOPIC_READERS, ZIP] if low.endswith(e.lower())), "")


def shown_name(name: str) -> str:
    """Return a file's name as it is shown and written into commands: without what could lead
    elsewhere, and without control codes.
    """
    parts = [part for part in name.replace("\\", "/").split("/") if part not in ("", ".", "..")]
    return "".join(letter for letter in "/".join(parts) if letter.isprintable())[-_LONGEST:]


@stream_request_body
class Upload(RequestHandler):
    """Takes one file, as the body of a request. The gate has looked at the cookie before."""

    def initialize(self, store: Store, most: int = MOST_BYTES) -> None:
        self._store, self._most = store, most
        self._path: Path | None = None
        self._left = most

    def prepare(self) -> None:
        """Refuse a body that is too large, or is no log, before it is read."""
        request: HTTPServerRequest = self.request
        name = unquote(request.headers.get("X-Name", ""))
        self._drop = request.headers.get("X-Drop", "")
        if request.method != "POST":
            return
        if int(request.headers.get("Content-Length", self._most + 1)) > self._most:
            self._refuse(_TOO_LARGE, f"more than {self._most >> 20:,} MB: cut the log")
            return
        request.connection.set_max_body_size(self._most)  # type: ignore[union-attr]
        try:
            self._path = self._store.new_path(name, self._drop)
        except ValueError as error:
            self._refuse(_UNKNOWN, str(error))
            return
        self._file = self._path.open("wb")

    def _refuse(self, status: int, words: str) -> None:
        self.set_status(status)
        self.finish(words)

    def data_received(self, chunk: bytes) -> None:
        """Write what came."""
        self._left -= len(chunk)
        if self._path is not None and self._left >= 0:
            self._file.write(chunk)

    def post(self) -> None:
        """Close the file. The page tells when all of a drop have arrived."""
        self._close(whole=self._left >= 0)
        self.finish("")

    def on_connection_close(self) -> None:
        """Delete what came of a file that is broken off."""
        self._close(whole=False)

    def _close(self, whole: bool) -> None:
        if self._path is None:
            return
        self._file.close()
        if not whole:
            self._store.forget(self._path, self._drop)
        self._path = None
