"""The results of a campaign on disk: one part a flight, each written whole or not at all.

`flights/ab/<key>.json` is the part of a flight: its case, its rows, its failures, what made them,
the number of this layout, and a checksum. A failure is a result too. `logs/ab/<key>-<data system>`
are the logs that are kept. Only the driver writes, and only while it holds the lock. All else in
the folder can be made again from the parts.
"""

import json
import os
import socket
import sqlite3
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from glob import glob
from hashlib import sha256
from pathlib import Path
from typing import Any, ClassVar

from pydantic import TypeAdapter, create_model

from pitotbench.campaigns.digests import aircraft_digest, code_digest
from pitotbench.campaigns.fleet import Failure
from pitotbench.campaigns.task import SCHEMA, Row, Task, TaskOutcome, host_class
from pitotbench.records import BadInputError
from pitotbench.records.case import Case, DataSystem
from pitotbench.records.case_file import case_columns, write_case
from pitotbench.records.flight import Score
from pitotbench.records.outputs import lock
from pitotbench.show.markup import Section
from pitotbench.units import KNOT
from pitotbench.version import version_of

Document = dict[str, Any]
PARTS, LOGS, INDEX = "flights", "logs", "index.parquet"
LOCK, OWNER, _SCRATCH = "lock.sqlite", "owner.json", "scratch"
DONE, FAILED, QUARANTINED = "done", "failed", "quarantined"
STATES = (DONE, FAILED, QUARANTINED)


class StoreError(BadInputError):
    """The store cannot be written. What it holds is whole."""


@dataclass(frozen=True, slots=True)
class ResultStore:
    """The store in a folder. Reading needs no lock; `with store:` takes it, for writing.

    `sync` waits for the disk after every part, so that no part is lost or cut where the power goes.
    """

    folder: Path
    sync: bool = True

    _locks: ClassVar[dict[Path, sqlite3.Connection]] = {}  # the locks of this process

    def __enter__(self) -> "ResultStore":
        """Take the lock and clear what a killed driver left.

        Raises BadInputError where another driver holds it.
        """
        try:
            (self.folder / _SCRATCH).mkdir(parents=True, exist_ok=True)
            held = lock(self.folder / LOCK)
        except OSError as error:
            raise StoreError(
                f"{self.folder}: cannot be made: {error.strerror}; choose another --out"
            ) from error
        except sqlite3.Error as error:
            if error.sqlite_errorcode == sqlite3.SQLITE_BUSY:
                raise BadInputError(
                    f"{self.folder} belongs to another campaign that runs now: {self.owner()}"
                ) from error
            raise StoreError(
                f"{self.folder / LOCK}: cannot be locked: {error}; delete it, it holds no result, "
                "or choose another --out"
            ) from error
        self._locks[self.folder] = held
        owner = {"host": socket.gethostname(), "process": os.getpid(), "since": time.time()}
        with suppress(OSError):  # a full disk: the lock holds all the same
            (self.folder / OWNER).unlink(missing_ok=True)  # writing into a pipe would wait
            (self.folder / OWNER).write_text(json.dumps(owner), encoding="utf-8")
            for file in (self.folder / _SCRATCH).iterdir():
                file.unlink()
        return self

    def __exit__(self, *_: object) -> None:
        self._locks.pop(self.folder).close()

    def owner(self) -> str:
        """Return in words who took the lock last."""
        try:
            stated = json.loads((self.folder / OWNER).read_bytes())
            age = max(0.0, time.time() - float(stated["since"]))  # the clock may have been set back
            return f"process {stated['process']} on {stated['host']}, for {age / 60.0:.0f} min"
        except (OSError, ValueError, KeyError, TypeError):
            return "its owner is not known"

    def part(self, key: str) -> Path:
        """Return the file of a part, whether it exists or not."""
        return self.folder / PARTS / key[:2] / f"{key}.json"

    def log(self, key: str, name: str) -> Path:
        """Return the file of a log by the end of its name."""
        return self.folder / LOGS / key[:2] / f"{key}-{name}"

    def find(self, key: str) -> Document | None:
        """Return the part of a key, None where there is none or where it is damaged.

        A damaged one is no file, or not of this key and layout. Raises StoreError where the disk
        does not give it.
        """
        path = self.part(key)
        try:
            if not path.is_file() and not path.is_dir():  # a pipe or a device may never end
                return None
            text = path.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise StoreError(f"{path}: cannot be read: {error.strerror}") from error
        begin = len(text) - _SEAL_LENGTH
        if begin < 0 or text[begin:] != _seal(text[:begin]):  # a damaged part is not even parsed
            return None
        try:
            _parts().validate_json(text, strict=True)
            document: Document = json.loads(text)
        except (ValueError, RecursionError):  # sealed by another hand
            return None
        del document["checksum"]
        return document if (document.get("key"), document.get("schema")) == (key, SCHEMA) else None

    def put(self, key: str, document: Mapping[str, Any], logs: Mapping[str, bytes]) -> None:
        """Keep a result: its logs first, then its part, which so never names a missing log.

        Raises StoreError where the disk takes no more. Nothing that was stored before is lost.
        """
        for name, content in logs.items():
            self._write(self.log(key, name), content)
        if self.part(key).exists():  # the index holds what is replaced here
            (self.folder / INDEX).unlink(missing_ok=True)
        stated = {**document, "key": key, "schema": SCHEMA, "logs": sorted(logs)}
        text = json.dumps(stated, allow_nan=True)[:-1].encode()
        self._write(self.part(key), text + _seal(text))

    def has_logs(self, document: Document) -> bool:
        """Return whether every log that a part names is there."""
        return all(self.log(document["key"], name).is_file() for name in document["logs"])

    def keys(self) -> Iterator[str]:
        """Give the keys of all parts."""
        names = sorted(glob("*/*.json", root_dir=self.folder / PARTS))
        return (os.path.basename(name).removesuffix(".json") for name in names)

    def _write(self, path: Path, content: bytes) -> None:
        scratch = self.folder / _SCRATCH / path.name
        try:
            with scratch.open("wb") as file:
                file.write(content)
                file.flush()
                if self.sync:
                    os.fsync(file.fileno())
            path.parent.mkdir(parents=True, exist_ok=True)
            scratch.replace(path)
        except OSError as error:
            with suppress(OSError):
                scratch.unlink()
            raise StoreError(
                f"{self.folder}: {error.strerror or error}; what is stored is whole: make room or "
                "change the folder, then give the same command again"
            ) from error


# The shape of a part: its fields with their types, and those of what made it.
_MADE: Mapping[str, Any] = {
    **dict.fromkeys(("code", "aircraft", "host"), str),
    **{"versions": dict[str, str], "cpu_s": float, "wall_s": float},
}
_SHAPE: Mapping[str, Any] = {
    **dict.fromkeys(("name", "state", "case", "keep_logs", "log_format"), str),
    **{"drawn": str, "columns": dict[str, Any]},
    **{"das": list[DataSystem], "calibrations": list[tuple[str, dict[str, Any]]]},
    **{"rows": list[Row], "sections": list[Section], "failures": list[str], "logs": list[str]},
}


def _seal(text: bytes) -> bytes:
    """Return the end of a part: the checksum of all that stands before it."""
    return f', "checksum": "{sha256(text).hexdigest()}"}}'.encode()


_SEAL_LENGTH = len(_seal(b""))


def stored(task: Task, result: TaskOutcome | Failure) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Return the document of a result, with case, code, versions and machine, and its logs.

    Raises BadInputError for a result that other code has made.
    """
    trace = ""
    if isinstance(result, Failure):
        outcome = TaskOutcome(
            failures=(f"{task.name}: {result.reason}",), code=code_digest(), host=host_class()
        )
        state, trace = QUARANTINED if result.quarantined else FAILED, result.trace
    else:
        outcome, state = result, DONE if result.rows else FAILED
    if outcome.code != code_digest():
        raise BadInputError(
            "a worker that came later has other code than the driver; install the same"
        )
    plain = _default_columns()
    columns = {
        name: value for name, value in case_columns(task.case).items() if plain.get(name) != value
    }
    document = {
        "name": task.name,
        "state": state,
        "case": write_case(task.case),
        "columns": columns,
        "das": [asdict(system) for system in task.systems],
        "calibrations": [[label, asdict(options)] for label, options in task.calibrations],
        "rows": [asdict(row) for row in outcome.rows],
        "sections": [asdict(section) for section in outcome.sections],
        "failures": list(outcome.failures),
        "trace": trace,
        "keep_logs": task.keep_logs,
        "log_format": task.log_format,
        "drawn": task.draw,
        "made": {
            "code": outcome.code,
            "aircraft": aircraft_digest(task.case.aircraft),
            "versions": _versions(),
            "host": outcome.host,
            "cpu_s": round(outcome.cpu_seconds, 3),
            "wall_s": round(outcome.seconds, 3),
        },
    }
    return document, outcome.logs


def satisfies(document: Mapping[str, Any], task: Task) -> bool:
    """Return whether a stored result has all that a task asks for: logs and figures.

    The logs have to be in their format.
    """
    if document["state"] == QUARANTINED or (
        document["state"] == FAILED and task.keep_logs == "none"
    ):
        return True
    logs = task.keep_logs == "none" or document["keep_logs"] in ("all", task.keep_logs)
    right = task.keep_logs == "none" or document["log_format"] == task.log_format
    return logs and right and (task.draw in ("", document["drawn"]) or not document["rows"])


def rows_of(document: Mapping[str, Any]) -> tuple[Row, ...]:
    """Return the rows of a stored result."""
    return tuple(Row(**{**row, "score": Score(**row["score"])}) for row in document["rows"])


def sections_of(document: Mapping[str, Any]) -> tuple[Section, ...]:
    """Return the finished parts of the report of a stored result."""
    return tuple(_sections().validate_python(document["sections"]))


def row_columns(row: Row) -> dict[str, object]:
    """Return a row as columns whose names end in units, in the order of results.parquet."""
    score = row.score
    return {
        "maneuver": row.maneuver,
        "das": row.das,
        "model": row.model,
        "seed": row.seed,
        "turbulence": row.turbulence,
        "minutes": score.minutes,
        "samples": score.samples,
        "residual_two_sigma_kt": score.residual_two_sigma / KNOT,
        "two_sigma_kt": score.two_sigma / KNOT,
        "curve_rms_error_kt": score.curve_rms_error / KNOT,
        "wind_error_kt": score.wind_error / KNOT,
        "curve_coverage": score.curve_coverage,
        "on_condition_share": score.on_condition_share,
    }


def all_columns(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return every number, text and list of a stored result's case by its path with its unit."""
    return {**_default_columns(), **document["columns"]}


@cache
def _default_columns() -> dict[str, Any]:
    return case_columns(Case())


@cache
def _parts() -> TypeAdapter[Any]:
    made, part = (_fields(of) for of in (_MADE, _SHAPE))
    return TypeAdapter(create_model("Part", made=(create_model("Made", **made), ...), **part))


def _fields(shape: Mapping[str, Any]) -> Any:
    return {name: (kind, ...) for name, kind in shape.items()}


@cache
def _sections() -> TypeAdapter[list[Section]]:
    return TypeAdapter(list[Section])


def _versions() -> dict[str, str]:
    return {name: version_of(name) for name in ("pitotbench", "jsbsim", "numpy", "scipy")}
