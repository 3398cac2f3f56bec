"""A set of flights with a hidden truth: the truth is sealed before the first log is written.

A run that was stopped goes on where it was.
"""

import json
import secrets
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar

from pitotbench.campaigns.fleet import Failure, run_tasks
from pitotbench.logbook.formats import write_log
from pitotbench.records import BadInputError
from pitotbench.records.log import FlightLog

FURTHER = ("-b", "-c")  # ends of the names of the further flights of a case
HELD = "-held"  # end of the name of the flight that is held out
TRUTH, SEAL, FAILED = "truth.json", "truth.sha256", "failed.json"
Case = TypeVar("Case")
Flights = Callable[[Case], Iterator[tuple[str, FlightLog]]]


def seal(folder: Path, seed: int, cases: Sequence[Mapping[str, Any]]) -> str:
    """Write the truth of a set and its salted SHA-256; return the latter.

    A truth that is there already stays, and must be the same. Raises ValueError for another one.
    """
    told = json.loads(json.dumps(cases))
    if (folder / TRUTH).is_file():
        if opened(folder)["cases"] != told:
            raise ValueError(f"{folder}: another truth is sealed there: give another folder")
        return (folder / SEAL).read_text("utf-8").strip()
    text = json.dumps({"salt": secrets.token_hex(16), "seed": seed, "cases": told}, indent=1)
    digest = sha256(text.encode()).hexdigest()
    folder.mkdir(parents=True, exist_ok=True)
    (folder / TRUTH).write_text(text, encoding="utf-8")
    (folder / SEAL).write_text(digest + "\n", encoding="utf-8")
    return digest


def opened(folder: Path) -> dict[str, Any]:
    """Return the truth of a folder. Raises ValueError where it is not the one sealed."""
    return unsealed((folder / TRUTH).read_bytes(), (folder / SEAL).read_bytes())


def unsealed(truth: bytes, seal: bytes) -> dict[str, Any]:
    """Return a truth. Raises ValueError where it is not the one sealed."""
    if sha256(truth).hexdigest() != seal.decode().strip():
        raise ValueError("the truth does not match its seal")
    told: dict[str, Any] = json.loads(truth)
    return told


def write_logs(
    folder: Path, cases: Mapping[str, Case], flights: Flights[Case], jobs: int = 1
) -> dict[str, str]:
    """Fly the cases without a log and write their logs into a folder; return why some could not be
    flown, by name.

    `flights` yields the end of the name and the log of each flight of a case, the first flight
    last: who sees its log may judge the case. The failures are kept beside the logs.
    """
    logs, kept = folder / "logs", folder / FAILED
    logs.mkdir(parents=True, exist_ok=True)
    failed: dict[str, str] = json.loads(kept.read_text("utf-8")) if kept.is_file() else {}
    todo = [n for n in cases if n not in failed and not (logs / f"{n}.parquet").is_file()]
    write = partial(_write, logs, flights)
    done = run_tasks(write, [(name, cases[name]) for name in todo], jobs, label="flights")
    for name, result in zip(todo, done, strict=True):
        if isinstance(result, Failure):
            if not issubclass(result.kind, BadInputError):
                raise RuntimeError(f"{name}: {result}")
            failed[name] = result.reason
    kept.write_text(json.dumps(failed, indent=1), encoding="utf-8")
    return failed


def _write(logs: Path, flights: Flights[Case], work: tuple[str, Case]) -> None:
    name, case = work
    for end, log in flights(case):
        write_log(log, logs / f"{name}{end}.parquet")
