"""Tasks without a flight, for the measurements of the engine: they do nothing, crash, hang or eat memory."""

import hashlib
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pitotbench.bench.fleet import Failure


@dataclass(frozen=True, slots=True)
class Stub:
    """A task that does what its `deed` says."""

    key: str
    deed: str = ""


def act(task: Stub) -> str:
    """Do the deed of a task."""
    match task.deed.split():
        case ["crash"]:
            os.abort()
        case ["hang"]:
            time.sleep(1e6)
        case ["eat", gigabytes]:
            return str(len(bytearray(int(float(gigabytes) * 1e9))))
        case ["sleep", seconds]:
            time.sleep(float(seconds))
    return task.key


def stubs(count: int, deed: str = "") -> Iterator[Stub]:
    """Give so many tasks one by one."""
    return (Stub(hashlib.md5(str(number).encode()).hexdigest(), deed) for number in range(count))


def stub_outcome(task: Stub, result: str | Failure) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Return the document of a stub: as long as that of a flight."""
    failed = isinstance(result, Failure)
    state = "quarantined" if isinstance(result, Failure) and result.quarantined else "failed" if failed else "done"
    document = {
        "name": task.deed or task.key,
        "state": state,
        "case": "x" * 3000,
        "failures": [f"{task.deed}: {result.reason}"] if isinstance(result, Failure) else [],
        "trace": result.trace if isinstance(result, Failure) else "",
    }
    return document, {}
