"""One task of a campaign: fly, sense with every data system, calibrate in every way, and score."""

import platform
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

from pitotbench import bench
from pitotbench.bench.campaign.tasks import Task
from pitotbench.bench.code_digest import code_digest
from pitotbench.bench.flights import sense
from pitotbench.calibrate import CalibrationOptions
from pitotbench.logbook import write_log
from pitotbench.records.calibration import Calibration
from pitotbench.records.case import DataSystem
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.records.score import Score
from pitotbench.sense import LOG_CHANNELS
from pitotbench.show.section import Section

CHANNELS = (*LOG_CHANNELS, "position_north", "position_east", "calibrated_airspeed")  # logged and drawn


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the result: the maneuver, the data system, the model, the seed and the score.

    `calibration` is the label of the options, where a plan has several.
    """

    maneuver: str
    das: str
    model: str
    seed: int
    turbulence: str
    score: Score
    calibration: str = ""


@dataclass(frozen=True, slots=True)
class TaskOutcome:
    """The result of a task: its rows, a page section for each data system, its failures in words, and its logs.

    `logs` are the bytes of the files by the end of their names. `code` is the digest of the code that flew, `host`
    the class of the machine; the times are those of the whole task [s].
    """

    rows: tuple[Row, ...] = ()
    sections: tuple[Section, ...] = ()
    failures: tuple[str, ...] = ()
    logs: dict[str, bytes] = field(default_factory=dict)
    code: str = ""
    host: str = ""
    cpu_seconds: float = 0.0
    seconds: float = 0.0


def perform_task(task: Task) -> TaskOutcome:
    """Fly one task, sense it, calibrate and score. This runs in any process, and writes no file that stays."""
    cpu, begun = time.process_time(), time.perf_counter()
    flight = bench.fly(task.case, channels=CHANNELS)
    rows: list[Row] = []
    sections: list[Section] = []
    failures: list[str] = []
    logs: dict[str, bytes] = {}
    for system in task.systems:
        log = sense(flight, system)
        results, failed = _calibrated(task, system, log)
        if task.keep_logs == "all" or (task.keep_logs == "failed" and failed):
            logs[task.log_name(system)] = _bytes_of(log, task.log_format)
        failures += failed
        rows += _rows(system, results, flight)
        if task.draw and results:
            sections.append(_section(task, system, flight, log, results))
    times = (time.process_time() - cpu, time.perf_counter() - begun)
    return TaskOutcome(tuple(rows), tuple(sections), tuple(failures), logs, code_digest(), host_class(), *times)


def host_class() -> str:
    """Return the system, the processor and the version of Python, such as `Linux x86_64 CPython 3.11.7`."""
    names = (platform.system(), platform.machine(), platform.python_implementation(), platform.python_version())
    return " ".join(names)


Found = list[tuple[str, CalibrationOptions, Calibration]]


def _calibrated(task: Task, system: DataSystem, log: FlightLog) -> tuple[Found, list[str]]:
    found: Found = []
    failures = []
    for label, options in task.calibrations:
        try:
            found.append((label, options, bench.calibrate(log, options)))
        except (NoAnswerError, BadInputError) as error:
            failures.append(f"{task.name} {system.label} {_mark(label, options)}: {error}")
    return found, failures


def _mark(label: str, options: CalibrationOptions) -> str:
    return f"{label} {options.model}".strip()


def _rows(system: DataSystem, results: Found, flight: Flight) -> Iterator[Row]:
    case = flight.case
    for label, options, result in results:
        score = bench.score(result, flight)
        yield Row(case.maneuver, system.label, options.model, case.truth_seed, case.turbulence, score, label)


def _bytes_of(log: FlightLog, log_format: str) -> bytes:
    with TemporaryDirectory(prefix="pitotbench-") as folder:
        return write_log(log, Path(folder, f"log.{log_format}")).read_bytes()


def _section(task: Task, system: DataSystem, flight: Flight, log: FlightLog, results: Found) -> Section:
    # Imported here, because a worker that draws nothing need not load the drawing library.
    from pitotbench.show.draw_section import flight_section

    spec = flight.case.pressure_error
    fits = {_mark(label, options): result for label, options, result in results}
    truth = {name: bench.true_correction(spec, r.curve.indicated_airspeed) for name, r in fits.items()}
    # The flight is the same for every data system: it is drawn once.
    tolerances = bench.tolerances(flight.case) if system == task.systems[0] else None
    checked = bench.cross_check(log, task.calibrations[0][1], next(iter(fits.values()), None))
    return flight_section(flight, system.label, fits, truth, tolerances, checked)
