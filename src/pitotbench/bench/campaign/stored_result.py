"""What the store keeps of a flight, as plain data, and back."""

from collections.abc import Mapping
from dataclasses import asdict
from functools import cache
from importlib.metadata import version
from typing import Any

from pydantic import TypeAdapter

from pitotbench.bench.campaign.perform import Row, TaskOutcome, host_class
from pitotbench.bench.campaign.tasks import SCHEMA, Task
from pitotbench.bench.fleet import Failure
from pitotbench.bench.fleet.code_digest import aircraft_digest, code_digest
from pitotbench.records.case import Case
from pitotbench.records.case_file import case_columns, write_case
from pitotbench.records.errors import BadInputError
from pitotbench.records.score import Score
from pitotbench.show.section import Section
from pitotbench.units import KNOT

DONE, FAILED, QUARANTINED = "done", "failed", "quarantined"
STATES = (DONE, FAILED, QUARANTINED)


def stored(task: Task, result: TaskOutcome | Failure) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Return the document of a result and its logs. It names the case, the code, the versions and the machine.

    Raises BadInputError for a result that other code has made.
    """
    lost = isinstance(result, Failure)
    if isinstance(result, TaskOutcome) and result.code != code_digest():
        raise BadInputError("a worker that came later has other code than the driver; install the same")
    outcome = TaskOutcome(failures=(f"{task.name}: {result.reason}",)) if isinstance(result, Failure) else result
    state = QUARANTINED if isinstance(result, Failure) and result.quarantined else DONE if outcome.rows else FAILED
    plain = _default_columns()
    columns = {name: value for name, value in case_columns(task.case).items() if plain.get(name) != value}
    document = {
        "schema": SCHEMA,
        "name": task.name,
        "state": state,
        "case": write_case(task.case),
        "columns": columns,
        "das": [asdict(system) for system in task.systems],
        "calibrations": [[label, asdict(options)] for label, options in task.calibrations],
        "rows": [asdict(row) for row in outcome.rows],
        "sections": [asdict(section) for section in outcome.sections],
        "failures": list(outcome.failures),
        "trace": result.trace if isinstance(result, Failure) else "",
        "keep_logs": task.keep_logs,
        "log_format": task.log_format,
        "drawn": task.draw,
        "made": {
            "code": code_digest() if lost else outcome.code,
            "aircraft": aircraft_digest(task.case.aircraft),
            "versions": _versions(),
            "host": host_class() if lost else outcome.host,
            "cpu_s": round(outcome.cpu_seconds, 3),
            "wall_s": round(outcome.seconds, 3),
        },
    }
    return document, outcome.logs


def satisfies(document: Mapping[str, Any], task: Task) -> bool:
    """Return whether a stored result has all that a task asks for: its logs in their format, and its figures."""
    if document["state"] == QUARANTINED or (document["state"] == FAILED and task.keep_logs == "none"):
        return True
    logs = task.keep_logs == "none" or document["keep_logs"] in ("all", task.keep_logs)
    right = task.keep_logs == "none" or document["log_format"] == task.log_format
    return logs and right and (document["drawn"] or not task.draw or not document["rows"])


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
def _sections() -> TypeAdapter[list[Section]]:
    return TypeAdapter(list[Section])


@cache
def _versions() -> dict[str, str]:
    return {name: version(name) for name in ("pitotbench", "jsbsim", "numpy", "scipy")}
