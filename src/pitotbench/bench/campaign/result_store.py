"""The results of a campaign on disk: one part a flight, each written whole or not at all.

`flights/ab/<key>.json` is the part of a flight: its case, its rows, its failures, and what made them. A failure is
a result too. `logs/ab/<key>-<data system>` are the logs that are kept. Only the driver writes, and only while it
holds the lock. All else in the folder can be made again from the parts.
"""

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from pitotbench.bench.campaign.store_lock import StoreLock
from pitotbench.records.errors import BadInputError

Document = dict[str, Any]
PARTS, LOGS, INDEX, PUBLISHED, _SCRATCH = "flights", "logs", "index.parquet", "published.json", "scratch"


class StoreError(BadInputError):
    """The store cannot be written. What it holds is whole."""


@dataclass(frozen=True, slots=True)
class ResultStore:
    """The store in a folder. Reading needs no lock; `with store:` takes it, for writing.

    `sync` waits for the disk after every part, so that no part is lost or cut where the power goes.
    """

    folder: Path
    sync: bool = True

    def __enter__(self) -> "ResultStore":
        """Take the lock and clear what a killed driver left. Raises BadInputError where another driver holds it."""
        try:
            (self.folder / _SCRATCH).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StoreError(f"{self.folder}: cannot be made: {error.strerror}; choose another --out") from error
        StoreLock(self.folder).take()
        with suppress(OSError):
            for file in (self.folder / _SCRATCH).iterdir():
                file.unlink()
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        StoreLock(self.folder).release()

    def part(self, key: str) -> Path:
        """Return the file of a part, whether it exists or not."""
        return self.folder / PARTS / key[:2] / f"{key}.json"

    def log(self, key: str, name: str) -> Path:
        """Return the file of a log by the end of its name."""
        return self.folder / LOGS / key[:2] / f"{key}-{name}"

    def find(self, key: str) -> Document | None:
        """Return the part of a key; None where there is none, or where it is cut or not of this key.

        Raises StoreError where the disk does not give it.
        """
        try:
            document = json.loads(self.part(key).read_bytes())
        except (FileNotFoundError, ValueError):
            return None
        except OSError as error:
            raise StoreError(f"{self.part(key)}: cannot be read: {error.strerror}") from error
        return document if isinstance(document, dict) and document.get("key") == key else None

    def put(self, key: str, document: Mapping[str, Any], logs: Mapping[str, bytes]) -> None:
        """Keep a result: its logs first, then its part, so that a part never names a log that is not there.

        Raises StoreError where the disk takes no more. Nothing that was stored before is lost.
        """
        (self.folder / PUBLISHED).unlink(missing_ok=True)  # the table of the folder lacks what is stored here
        for name, content in logs.items():
            self._write(self.log(key, name), content)
        if self.part(key).exists():  # the index holds what is replaced here
            (self.folder / INDEX).unlink(missing_ok=True)
        text = json.dumps({**document, "key": key, "logs": sorted(logs)}, allow_nan=True)
        self._write(self.part(key), text.encode())

    def keys(self) -> Iterator[str]:
        """Give the keys of all parts."""
        try:
            shelves = sorted(os.listdir(self.folder / PARTS))
        except FileNotFoundError:
            return
        for shelf in shelves:
            for name in sorted(os.listdir(self.folder / PARTS / shelf)):
                if name.endswith(".json"):
                    yield name.removesuffix(".json")

    def _write(self, path: Path, content: bytes) -> None:
        scratch = self.folder / _SCRATCH / path.name
        try:
            with scratch.open("wb") as file:
                file.write(content)
                file.flush()
                if self.sync:
                    os.fsync(file.fileno())
            try:
                scratch.replace(path)
            except FileNotFoundError:
                path.parent.mkdir(parents=True, exist_ok=True)
                scratch.replace(path)
        except OSError as error:
            with suppress(OSError):
                scratch.unlink()
            raise StoreError(
                f"{self.folder}: {error.strerror or error}; what is stored is whole: "
                "make room or change the folder, then give the same command again"
            ) from error
