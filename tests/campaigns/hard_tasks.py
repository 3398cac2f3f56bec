"""Tasks that crash, hang or eat memory, for the tests of fleets and campaigns. A worker imports
them from here.
"""

import os
import time
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Stub:
    """A task that does what its `deed` says, and notes in a folder that it was performed."""

    key: str
    deed: str = ""
    notes: str = ""


def act(task: Stub) -> str:
    """Do the deed of a task and return its key."""
    if task.notes:
        with Path(task.notes, f"{task.key}-{os.getpid()}-{time.monotonic_ns()}").open("w"):
            pass
    name, _, number = task.deed.partition(" ")
    if name == "crash":
        os.write(2, b"the simulator fell over\n")
        os.abort()
    if name == "crash-once" and not Path(task.notes, "crashed").exists():
        Path(task.notes, "crashed").touch()
        os._exit(7)
    if name == "lose" or (name == "lose-once" and not Path(task.notes, "lost").exists()):
        if task.notes:
            Path(task.notes, "lost").touch()
        raise FileNotFoundError(2, "No such file or directory", "/gone")
    if name == "exit":
        os._exit(1)
    if name in ("hang", "sleep"):
        time.sleep(float(number or 1000))
    if name == "eat":
        return str(len(bytearray(int(float(number) * 1e9))))
    if name == "refuse":
        raise ValueError("not flown")
    return task.key


def stored(task, result):
    """Return the document of a stub, as the store keeps it."""
    from pitotbench.campaigns.fleet import Failure

    failed = isinstance(result, Failure)
    state = "done" if not failed else "quarantined" if result.quarantined else "failed"
    document = {"name": task.key, "state": state, "case": task.deed, "columns": {}, "das": []}
    document |= {"calibrations": [], "rows": [], "sections": [], "keep_logs": "none"}
    made = {"code": "", "aircraft": "", "versions": {}, "host": "", "cpu_s": 0.0, "wall_s": 0.0}
    document |= {"log_format": "", "drawn": "", "made": made}
    return document | {
        "failures": [f"{task.key}: {result.reason}"] if failed else [],
        "trace": getattr(result, "trace", ""),
    }, {}
