"""Fly the tasks: in this process, in spawned ones, or on a cluster, all through one Executor interface."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from pitotbench import bench
from pitotbench.bench.campaign.tasks import Task
from pitotbench.logbook import write_log
from pitotbench.records.calibration import Calibration
from pitotbench.records.case import Case
from pitotbench.records.case_file import write_case
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.records.score import Score
from pitotbench.show.section import Section

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the result: which maneuver, data system, model and seed, and how it did."""

    maneuver: str
    das: str
    model: str
    seed: int
    turbulence: str
    score: Score


@dataclass(frozen=True, slots=True)
class TaskOutcome:
    """What a task gives back: rows, a page section a data system, and what went wrong in words."""

    task: str
    rows: tuple[Row, ...]
    sections: tuple[Section, ...]
    failures: tuple[str, ...]


def perform_task(task: Task) -> TaskOutcome:
    """Fly one task, write its logs and its resolved case, calibrate and score. Runs in any process."""
    case = replace(task.case, das=bench.with_das(task.case, task.systems[0]).das)
    flight = bench.fly(case)
    Path(task.folder, "cases").mkdir(parents=True, exist_ok=True)
    Path(task.folder, "cases", f"{task.name}.toml").write_text(write_case(case), encoding="utf-8")
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
    # Imported here: a worker that draws nothing need not load the drawing library.
    from pitotbench.show.draw_section import flight_section

    spec = flight.case.pressure_error
    truth = {name: bench.true_correction(spec, r.curve.indicated_airspeed) for name, r in results.items()}
    # The flight is the same for every data system: it is drawn once.
    tolerances = bench.tolerances(flight.case) if system == task.systems[0] else None
    return flight_section(flight, system, results, truth, tolerances, bench.cross_check(log, task.options))


def run_tasks(tasks: Sequence[Task], executor: Executor | None, step: Callable[[], None]) -> list[TaskOutcome]:
    """Perform the tasks in the order given, whatever the order in which they end; `step` is called after each.

    A task that fails outright becomes an Outcome with its message; the others are not lost.
    """
    if executor is None:
        outcomes = {}
        for number, task in enumerate(tasks):
            outcomes[number] = _guarded(task)
            step()
        return [outcomes[number] for number in range(len(tasks))]
    futures: dict[Future[TaskOutcome], int] = {executor.submit(_guarded, t): i for i, t in enumerate(tasks)}
    done: dict[int, TaskOutcome] = {}
    for future in as_completed(futures):
        number = futures[future]
        failed = future.exception()
        done[number] = _lost(tasks[number], failed) if failed else future.result()
        step()
    return [done[number] for number in range(len(tasks))]


def _guarded(task: Task) -> TaskOutcome:
    try:
        return perform_task(task)
    except Exception as error:  # whatever it is, it is reported and the other flights are kept
        return _lost(task, error)


def _lost(task: Task, error: BaseException) -> TaskOutcome:
    """The outcome of a task that gave nothing; an error that is not ours also names its kind."""
    ours = isinstance(error, BadInputError | NoAnswerError)
    text = str(error) if ours else f"{type(error).__name__}: {error}"
    return TaskOutcome(task.name, (), (), (f"{task.name}: {text}",))


@contextmanager
def executor_for(jobs: int, scheduler: str | None) -> Iterator[Executor | None]:
    """None for one job, spawned processes for more, a dask client's executor for a scheduler address.

    Raises BadInputError where dask is not installed or the scheduler does not answer.
    """
    if scheduler is not None:
        with _cluster(scheduler) as executor:
            yield executor
    elif jobs <= 1:
        yield None
    else:
        with _one_thread(), ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
            yield pool


@contextmanager
def _one_thread() -> Iterator[None]:
    """One flight a core: threads inside a fit would only compete. Processes started inside inherit it."""
    before = {variable: os.environ.get(variable) for variable in _THREADS}
    os.environ.update({variable: "1" for variable, value in before.items() if value is None})
    try:
        yield
    finally:
        for variable in (name for name, value in before.items() if value is None):
            os.environ.pop(variable, None)


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    try:
        distributed: Any = import_module("distributed")
    except ImportError as error:
        raise BadInputError("--scheduler needs dask: pip install 'pitotbench[cluster]'") from error
    try:
        client = distributed.Client(address, timeout="10s")
    except (OSError, ValueError) as error:
        raise BadInputError(f"no dask scheduler answers at {address}: {error}") from error
    with client:
        yield client.get_executor()
