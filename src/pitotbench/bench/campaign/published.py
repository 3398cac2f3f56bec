"""Whether the files of a campaign's folder are those of its plan already, so that they need not be made again."""

import json
from collections.abc import Iterable, Iterator, Sequence
from hashlib import sha256
from pathlib import Path

from pitotbench.bench.campaign.tasks import Task
from pitotbench.bench.store import PUBLISHED, ResultStore
from pitotbench.logbook import write_text


class PlanDigest:
    """The digest of all that decides the files of a folder: the tasks as they pass, and what else is `stated`."""

    def __init__(self, *stated: object) -> None:
        self._digest = sha256(repr(stated).encode())

    def of(self, tasks: Iterable[Task]) -> Iterator[Task]:
        """Give the tasks, and take each into the digest."""
        for task in tasks:
            self._digest.update(f"{task.key} {task.name} {task.draw}\n".encode())
            yield task

    def hexdigest(self) -> str:
        """Return the digest of the tasks that have passed."""
        return self._digest.hexdigest()


def note_published(folder: Path, store: ResultStore, plan: str, failures: Sequence[str]) -> None:
    """Note that the files of a folder are those of a plan, with the failures in words."""
    text = json.dumps({"plan": plan, "files": _stamps(folder), "failures": [*failures]})
    write_text(store.folder / PUBLISHED, text)


def published(folder: Path, store: ResultStore, plan: str) -> tuple[str, ...] | None:
    """Return the failures in words where the files of a folder are those of a plan; None where they are not.

    A file that was changed, moved or removed since, and any part that was stored since, make them another's.
    """
    try:
        noted = json.loads((store.folder / PUBLISHED).read_bytes())
        same = noted["plan"] == plan and noted["files"] == _stamps(folder)
        return tuple(noted["failures"]) if same else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _stamps(folder: Path) -> list[list[object]]:
    """Return the name, the size and the time of every file outside of the store."""
    files = [*folder.glob("*.*"), *folder.glob("logs/*"), *folder.glob("cases/*")]
    stats = ((file, file.stat()) for file in sorted(files))
    return [[file.relative_to(folder).as_posix(), stat.st_size, stat.st_mtime_ns] for file, stat in stats]
