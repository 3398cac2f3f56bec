"""Campaigns driven from outside, and tasks without a flight that do nothing, crash, hang or eat
memory.
"""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import md5, sha256
from pathlib import Path
from typing import Any

import tomli_w

from pitotbench.campaigns.fleet import Failure

CLOCK = os.sysconf("SC_CLK_TCK")
# As docs/scale.md recommends: no repetition of a task that kills its worker, no sampling of what
# workers do.
DASK_SETTINGS = {
    "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1",
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "1s",
}
_SHORTEST_CARD = {"speeds_kt": [130.0, 110.0], "dwells_s": [10.0, 10.0], "settle_s": 2.0}
_SOURCE = Path(__file__).parents[2]


def write_plan_file(folder: Path, seeds: str, **more: object) -> Path:
    """Write the plan of the shortest flight that can be calibrated, at 2/1 Hz, with these seeds."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "short.toml"
    table = {
        "das": ["2/1"],
        "seeds": seeds,
        "case": {"maneuver": "decel_circle", "card": _SHORTEST_CARD},
    }
    path.write_text(tomli_w.dumps(table | more), encoding="utf-8")
    return path


def start(plan: Path, out: Path, *flags: str) -> "subprocess.Popen[str]":
    """Start `pitotbench campaign` in a process of its own."""
    command = [sys.executable, "-m", "pitotbench", "campaign", str(plan), "--out", str(out)]
    command += ["--keep-logs", "none", "--progress", "lines", *flags]
    settings, pipe = os.environ | {"PYTHONPATH": str(_SOURCE), "COLUMNS": "200"}, subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=settings)


@dataclass(frozen=True, slots=True)
class Ended:
    """How a campaign ended: exit code, last line, seconds, CPU seconds of all its processes."""

    code: int
    said: str
    seconds: float
    cpu: float


def finish(driver: "subprocess.Popen[str]", begun: float) -> Ended:
    """Wait for a campaign, and return how it ended."""
    before = children_cpu()
    out, said = driver.communicate()
    cpu = children_cpu() - before
    lines = (said.strip() or out.strip()).splitlines() or [""]
    return Ended(driver.returncode, lines[-1], time.monotonic() - begun, cpu)


def children_cpu() -> float:
    """Return the CPU seconds of the children that have ended."""
    times = os.times()
    return times.children_user + times.children_system


def fly_campaign(plan: Path, out: Path, *flags: str) -> Ended:
    """Run a campaign to its end."""
    begun = time.monotonic()
    return finish(start(plan, out, *flags), begun)


def descendants(pid: int) -> list[int]:
    """Return the processes that a process has started, and those that these have started."""
    children: dict[int, list[int]] = {}
    for place in Path("/proc").glob("[0-9]*"):
        fields = _stat(int(place.name))
        if fields and fields[0] != "Z":
            children.setdefault(int(fields[1]), []).append(int(place.name))
    found, todo = [], [pid]
    while todo:
        new = children.get(todo.pop(), [])
        found += new
        todo += new
    return found


def _stat(pid: int) -> list[str]:
    """Return the fields of a process from its state on, none where it has ended."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return []


def alive(pid: int) -> bool:
    """Return whether a process runs; one that has ended and was not yet collected does not."""
    return _stat(pid)[:1] not in ([], ["Z"])


def memory(pid: int) -> float:
    """Return the resident memory of a process [MB]; 0 where it has ended."""
    try:
        told = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0.0
    resident = re.search(r"^VmRSS:\s*(\d+)", told, re.MULTILINE)
    return float(resident[1]) / 1024.0 if resident else 0.0


def wait_for_parts(out: Path, count: int, driver: "subprocess.Popen[str]") -> None:
    """Wait until a store holds so many parts, or the driver has ended."""
    while driver.poll() is None and parts(out) < count:
        time.sleep(0.05)


def parts_of(out: Path) -> list[Path]:
    """Return the parts of the store of a campaign."""
    return list((out / "store" / "flights").glob("*/*.json"))


def parts(out: Path) -> int:
    """Return the number of parts of a store."""
    return len(parts_of(out))


def stamps(out: Path) -> dict[Path, int]:
    """Return when each part was written, by the clock of the disk [ns]."""
    return {path: path.stat().st_mtime_ns for path in parts_of(out)}


def flown_again(out: Path, before: dict[Path, int]) -> int:
    """Return how many parts were written since these stamps, of those that were there."""
    return sum(path.stat().st_mtime_ns != stamp for path, stamp in before.items())


def kill(driver: "subprocess.Popen[str]", out: Path) -> tuple[int, int]:
    """Kill a driver; return its processes left after 5 s, and the stored flights lost."""
    started, before = descendants(driver.pid), parts(out)
    driver.kill()
    driver.communicate()
    time.sleep(5.0)
    return sum(map(alive, started)), max(before - parts(out), 0)


def digest(path: Path) -> str:
    """Return the digest of a file."""
    return sha256(path.read_bytes()).hexdigest()[:16]


def cpu_used(pid: int) -> float:
    """Return the CPU seconds of a process that runs, without its children."""
    return sum(map(int, _stat(pid)[11:13])) / CLOCK


@dataclass(frozen=True, slots=True)
class Cluster:
    """A dask cluster: the address of its scheduler, the processes of scheduler and workers."""

    address: str
    scheduler: int
    workers: int


@contextmanager
def dask_cluster(workers: int = 2, threads: int = 1) -> Iterator[Cluster]:
    """Start a scheduler and workers as docs/scale.md says."""
    port = 20000 + os.getpid() % 20000
    address = f"tcp://127.0.0.1:{port}"
    settings = os.environ | {"PYTHONPATH": str(_SOURCE), **DASK_SETTINGS}
    scheduler = ["scheduler", "--host", "tcp://127.0.0.1", "--port", str(port)]
    worker = ["worker", address, "--nworkers", str(workers), "--nthreads", str(threads)]
    started = [_dask(command, settings) for command in (scheduler, worker)]
    try:
        yield Cluster(address, *(process.pid for process in started))
    finally:
        for process in reversed(started):
            process.send_signal(signal.SIGINT)
        for process in reversed(started):
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()


def _dask(command: Sequence[str], settings: dict[str, str]) -> "subprocess.Popen[bytes]":
    words, quiet = [sys.executable, "-m", "dask", *command, "--no-dashboard"], subprocess.DEVNULL
    return subprocess.Popen(words, env=settings, stdout=quiet, stderr=quiet)


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
    return (Stub(md5(str(number).encode()).hexdigest(), deed) for number in range(count))


def stub_outcome(task: Stub, result: str | Failure) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Return the document of a stub: as long as that of a flight."""
    document = {
        "name": task.deed or task.key,
        "case": "x" * 3000,
        "state": "done",
        "failures": [],
        "trace": "",
        "columns": {},
        **{name: [] for name in ("das", "calibrations", "rows", "sections")},
        "keep_logs": "none",
        "log_format": "",
        "drawn": "",
        "made": dict.fromkeys(("code", "aircraft", "host"), "")
        | {"versions": {}, "cpu_s": 0.0, "wall_s": 0.0},
    }
    if isinstance(result, Failure):
        state, failure = "quarantined" if result.quarantined else "failed", result.reason
        told = {"state": state, "failures": [f"{task.deed}: {failure}"], "trace": result.trace}
        document |= told
    return document, {}
