"""One task of a campaign: fly, sense with every data system, calibrate in every way, and score."""

import json
import platform
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory

from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.campaigns import flights
from pitotbench.campaigns.digests import aircraft_digest, code_digest
from pitotbench.campaigns.flights import sense, true_correction
from pitotbench.logbook.formats import write_log
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import Calibration
from pitotbench.records.case import Case, DataSystem
from pitotbench.records.case_file import write_case
from pitotbench.records.flight import Flight, Score
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import LOG_CHANNELS
from pitotbench.show.calibration import short_answer_of
from pitotbench.show.markup import Section
from pitotbench.show.reader_units import units_named
from pitotbench.simulation.sortie import fly
from pitotbench.version import version_of

SCHEMA = 2  # of a stored result
KEEP_LOGS = ("none", "failed", "all")


Calibrations = tuple[tuple[str, CalibrationOptions], ...]


@dataclass(frozen=True, slots=True)
class Task:
    """One flight of a campaign: name, key, case, data systems that sense it, and its calibrations.

    `key` is that of `content_key`. `calibrations` are labels, which may be empty, with the options
    of each. `keep_logs` says which logs are kept: `none`, those of a `failed` calibration, or
    `all`. `draw` asks for the page of this flight, in the units of its words; without it only the
    short answers are kept.
    """

    name: str
    key: str
    case: Case
    systems: tuple[DataSystem, ...]
    calibrations: Calibrations
    log_format: str = "parquet"
    keep_logs: str = "all"
    draw: str = ""


def content_key(cell: str, case: Case) -> str:
    """Return the key of a flight: the digest of its cell and its seeds, 32 hexadecimal digits."""
    return sha256(f"{cell} {case.truth_seed} {case.sensor_seed}".encode()).hexdigest()[:32]


def cell_digest(case: Case, systems: Sequence[DataSystem], calibrations: Calibrations) -> str:
    """Return the digest of all that decides a result but the seeds.

    The case, the calibrations, and what computes: the schema, the code with its effects, the files
    of the aircraft, and JSBSim. Flights that differ in their seeds alone have one such digest,
    which takes longer to make than all else of a task.
    """
    content = [
        SCHEMA,
        write_case(replace(case, das=systems[0], truth_seed=0, sensor_seed=0)),
        [asdict(system) for system in systems],
        [[label, asdict(options)] for label, options in calibrations],
        code_digest(),
        aircraft_digest(case.aircraft),
        version_of("jsbsim"),
    ]
    return sha256(json.dumps(content, default=repr).encode()).hexdigest()


def sharded(tasks: Iterator[Task], shard: tuple[int, int]) -> Iterator[Task]:
    """Give every n-th task, from the k-th on, of a shard (k, n) that counts from 1."""
    part, parts = shard
    return (task for number, task in enumerate(tasks) if number % parts == part - 1)


# What is logged and drawn.
CHANNELS = (*LOG_CHANNELS, "position_north", "position_east", "calibrated_airspeed")


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
    """The result of a task: rows, a page section for each data system, failures in words, and logs.

    `logs` are the bytes of the files by the end of their names (`20_1.parquet`). `code` is the
    digest of the code that flew, `host` the class of the machine; the times are those of the whole
    task [s].
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
    """Fly one task, sense it, calibrate and score, in any process and without a lasting file."""
    cpu, begun = time.process_time(), time.perf_counter()
    flight = fly(task.case, channels=CHANNELS)
    rows: list[Row] = []
    sections: list[Section] = []
    failures: list[str] = []
    logs: dict[str, bytes] = {}
    for system in task.systems:
        log, results, before = sense(flight, system), Found(), len(failures)
        for label, options in task.calibrations:
            try:
                result = calibrate(log, options)
            except (NoAnswerError, BadInputError) as error:
                failures.append(f"{task.name} {system.label} {_mark(label, options)}: {error}")
                continue
            results.append((label, options, result))
            case, score = flight.case, flights.score(result, flight)
            rows.append(
                Row(
                    case.maneuver,
                    system.label,
                    options.model,
                    case.truth_seed,
                    case.turbulence,
                    score,
                    label,
                )
            )
        if task.keep_logs == "all" or (task.keep_logs == "failed" and len(failures) > before):
            with TemporaryDirectory(prefix="pitotbench-") as folder:
                written = write_log(log, Path(folder, f"log.{task.log_format}"))
                logs[f"{system.label.replace('/', '_')}.{task.log_format}"] = written.read_bytes()
        if results:
            sections.append(_section(task, system, flight, log, results))
    times = (time.process_time() - cpu, time.perf_counter() - begun)
    return TaskOutcome(
        tuple(rows), tuple(sections), tuple(failures), logs, code_digest(), host_class(), *times
    )


def host_class() -> str:
    """Return system, processor and version of Python, as in `Linux x86_64 CPython 3.11.7`."""
    return (
        f"{platform.system()} {platform.machine()} {platform.python_implementation()} "
        f"{platform.python_version()}"
    )


Found = list[tuple[str, CalibrationOptions, Calibration]]


def _mark(label: str, options: CalibrationOptions) -> str:
    return f"{label} {options.model}".strip()


def _section(
    task: Task, system: DataSystem, flight: Flight, log: FlightLog, results: Found
) -> Section:
    spec = flight.case.pressure_error
    if not task.draw:
        first = results[0][2]
        true = true_correction(spec, first.curve.indicated_airspeed)
        answer = short_answer_of(first, f"{task.name} {system.label}", true)
        return Section("", flight.case.maneuver, system.label, answer, "")
    # Imported here, because a worker that draws nothing need not load the drawing library, and who
    # reads stored results no estimator.
    from pitotbench.calibration.leg_points import cross_check
    from pitotbench.show.pages import flight_section

    fits = {_mark(label, options): result for label, options, result in results}
    truth = {name: true_correction(spec, r.curve.indicated_airspeed) for name, r in fits.items()}
    # The flight is the same for every data system: it is drawn once.
    tolerances = flights.tolerances(flight.case) if system == task.systems[0] else None
    for name, first in [*fits.items()][:1]:
        points = cross_check(log, task.calibrations[0][1], first)
        fits[name] = replace(first, points=points)
    return flight_section(flight, system.label, fits, truth, tolerances, units_named(task.draw))
