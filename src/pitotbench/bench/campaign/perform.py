"""One task of a campaign: fly, sense with every data system, calibrate with every model, and score."""

from dataclasses import dataclass, replace
from pathlib import Path

from pitotbench import bench
from pitotbench.bench.campaign.tasks import Task
from pitotbench.bench.fleet import Failure
from pitotbench.logbook import write_log, write_text
from pitotbench.records.calibration import Calibration
from pitotbench.records.case import Case
from pitotbench.records.case_file import write_case
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.records.score import Score
from pitotbench.show.section import Section


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the result: the maneuver, the data system, the model, the seed and the score."""

    maneuver: str
    das: str
    model: str
    seed: int
    turbulence: str
    score: Score


@dataclass(frozen=True, slots=True)
class TaskOutcome:
    """The result of a task: its rows, one page section for each data system, and its failures in words."""

    task: str
    rows: tuple[Row, ...]
    sections: tuple[Section, ...]
    failures: tuple[str, ...]


def perform_task(task: Task) -> TaskOutcome:
    """Fly one task, write its logs and its resolved case, calibrate and score. This runs in any process."""
    case = replace(task.case, das=bench.with_das(task.case, task.systems[0]).das)
    flight = bench.fly(case)
    Path(task.folder, "cases").mkdir(parents=True, exist_ok=True)
    write_text(Path(task.folder, "cases", f"{task.name}.toml"), write_case(case))
    rows: list[Row] = []
    sections: list[Section] = []
    failures: list[str] = []
    for system in task.systems:
        log = bench.sense(flight, system)
        _keep_log(task, system, log)
        results = _calibrate(task, system, log, failures)
        rows += [_row(case, system, model, result, flight) for model, result in results.items()]
        if task.draw and results:
            sections.append(_section(task, system, flight, log, results))
    return TaskOutcome(task.name, tuple(rows), tuple(sections), tuple(failures))


def _keep_log(task: Task, system: str, log: FlightLog) -> None:
    folder = Path(task.folder, "logs")
    folder.mkdir(parents=True, exist_ok=True)
    write_log(log, folder / f"{task.name}-{system.replace('/', '_')}.{task.log_format}")


def _calibrate(task: Task, system: str, log: FlightLog, failures: list[str]) -> dict[str, Calibration]:
    results = {}
    for model in task.models:
        try:
            results[model] = bench.calibrate(log, replace(task.options, model=model))
        except (NoAnswerError, BadInputError) as error:
            failures.append(f"{task.name} {system} {model}: {error}")
    return results


def _row(case: Case, system: str, model: str, result: Calibration, flight: Flight) -> Row:
    return Row(case.maneuver, system, model, case.truth_seed, case.turbulence, bench.score(result, flight))


def _section(task: Task, system: str, flight: Flight, log: FlightLog, results: dict[str, Calibration]) -> Section:
    # Imported here, because a worker that draws nothing need not load the drawing library.
    from pitotbench.show.draw_section import flight_section

    spec = flight.case.pressure_error
    truth = {name: bench.true_correction(spec, r.curve.indicated_airspeed) for name, r in results.items()}
    points = bench.cross_check(log, task.options, next(iter(results.values()), None))
    # The flight is the same for every data system: it is drawn once.
    tolerances = bench.tolerances(flight.case) if system == task.systems[0] else None
    return flight_section(flight, system, results, truth, tolerances, points)


def lost_task(task: Task, failure: Failure) -> TaskOutcome:
    """Return the outcome of a task that gave no result, with the reason."""
    return TaskOutcome(task.name, (), (), (f"{task.name}: {failure.reason}",))
