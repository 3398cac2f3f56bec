"""The lock of a store: one driver writes at a time.

The operating system holds it and frees it when its owner ends, however it ends, and whatever the clock says.
"""

import json
import os
import socket
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from pitotbench.records.errors import BadInputError

LOCK = "lock"


@dataclass(frozen=True, slots=True)
class StoreLock:
    """The lock of a folder. It names its owner and the time since when, for the message to another driver."""

    folder: Path

    _held: ClassVar[dict[Path, int]] = {}  # descriptors by folder

    def take(self) -> None:
        """Take the lock. Raises BadInputError that names the owner and the age where another process has it."""
        path = self.folder / LOCK
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise BadInputError(
                f"{self.folder}: cannot be written: {error.strerror}; choose another --out"
            ) from error
        if not _lock(descriptor):
            os.close(descriptor)
            raise BadInputError(f"{self.folder} belongs to another campaign that runs now: {self.owner()}")
        with suppress(OSError):  # a full disk: the lock holds all the same
            owner = {"host": socket.gethostname(), "process": os.getpid(), "since": time.time()}
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, json.dumps(owner).encode(), 0)
        self._held[self.folder] = descriptor

    def release(self) -> None:
        """Release the lock. The file stays: to remove it would free a lock that another driver has just taken."""
        descriptor = self._held.pop(self.folder, None)
        if descriptor is not None:
            os.close(descriptor)

    def owner(self) -> str:
        """Return the owner of the lock in words."""
        try:
            stated: dict[str, Any] = json.loads((self.folder / LOCK).read_bytes())
            age = max(0.0, time.time() - float(stated["since"]))  # the clock may have been set back
            return f"process {stated['process']} on {stated['host']}, for {age / 60.0:.0f} min"
        except (OSError, ValueError, KeyError, TypeError):
            return "its owner is not known"


if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> bool:
        try:
            os.lseek(descriptor, 1 << 30, os.SEEK_SET)  # far behind the text, which others read
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

else:
    import fcntl

    def _lock(descriptor: int) -> bool:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True
