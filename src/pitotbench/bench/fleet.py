"""Run many flights, in this process, in spawned processes, or on a cluster.

A task is all the work on one flight. The results are in the order of the tasks, not in the order in which the tasks
end. They are the same bit for bit for any number of processes.
"""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from multiprocessing import get_context
from traceback import format_exception
from typing import Any, TypeVar

from pitotbench.catalog import UnknownNameError
from pitotbench.records.errors import BadInputError, NoAnswerError

T = TypeVar("T")
R = TypeVar("R")
Step = Callable[[], None]

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_EXPECTED = (BadInputError, NoAnswerError, UnknownNameError)


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a task gave no result, in words.

    `kind` is the type of the error that `require_all` raises for it. `trace` is the traceback, kept only for an
    error that the bench does not expect.
    """

    reason: str
    kind: type[Exception] = RuntimeError
    trace: str = ""

    @classmethod
    def of(cls, error: BaseException) -> "Failure":
        """Return the failure that describes an error. It names the type of an error that the bench does not expect.

        The error itself is not kept, because not every error can be sent from one process to another.
        """
        for kind in _EXPECTED:
            if isinstance(error, kind):
                return cls(str(error), kind)
        return cls(f"{type(error).__name__}: {error}", trace="".join(format_exception(error)))


@dataclass(frozen=True, slots=True)
class Fleet:
    """Performs tasks through an executor, or in this process where the executor is None."""

    executor: Executor | None = None

    def perform(self, work: Callable[[T], R], tasks: Sequence[T], step: Step = lambda: None) -> list[R | Failure]:
        """Return the result of `work` for every task, in the order of the tasks. `step` is called after each task.

        A task that raises an error gives a Failure, and the other tasks go on. With an executor, `work` and the
        tasks must be picklable.
        """
        if self.executor is None:
            return [_in_turn(work, task, step) for task in tasks]
        futures: dict[Future[R | Failure], int] = {
            self.executor.submit(_attempted, work, task): place for place, task in enumerate(tasks)
        }
        done: dict[int, R | Failure] = {}
        for future in as_completed(futures):
            # A process that dies, or a result that cannot be pickled, fails outside `_attempted`.
            failed = future.exception()
            done[futures[future]] = Failure.of(failed) if failed else future.result()
            step()
        return [done[place] for place in range(len(tasks))]


def run_tasks(
    work: Callable[[T], R],
    tasks: Sequence[T],
    jobs: int | None = None,
    scheduler: str | None = None,
    label: str = "",
    step: Step = lambda: None,
) -> list[R | Failure]:
    """Open a fleet, perform the tasks and close the fleet.

    `jobs` is the number of processes, by default one for each core and no more than there are tasks. `label` names
    a progress bar; without it there is no bar. Raises BadInputError as `open_fleet` does.
    """
    with open_fleet(jobs, scheduler, len(tasks)) as fleet, progress(label, len(tasks)) as advance:

        def after_each() -> None:
            advance()
            step()

        return fleet.perform(work, tasks, after_each)


def require_all(results: Sequence[R | Failure]) -> list[R]:
    """Return the results. Where a task failed, raise the first failure as an error of its kind instead."""
    for result in results:
        if isinstance(result, Failure):
            raise result.kind(f"{result.reason}\n{result.trace}".rstrip())
    return [result for result in results if not isinstance(result, Failure)]


@contextmanager
def open_fleet(jobs: int | None = None, scheduler: str | None = None, tasks: int | None = None) -> Iterator[Fleet]:
    """Give a fleet: this process for one job, spawned processes for more, a dask cluster for a scheduler's address.

    Without `jobs` there is one process for each core, and no more than `tasks`.
    Raises BadInputError where dask is not installed or the scheduler does not answer.
    """
    if scheduler is not None:
        with _cluster(scheduler) as executor:
            yield Fleet(executor)
        return
    cores = os.cpu_count() or 1
    processes = jobs or (cores if tasks is None else min(cores, tasks))
    if processes <= 1:
        yield Fleet()
        return
    with _one_thread(), ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        try:
            yield Fleet(pool)
        except BaseException:  # an interrupt as well: do not wait for tasks that have not begun
            pool.shutdown(wait=False, cancel_futures=True)
            raise


@contextmanager
def progress(label: str, total: int) -> Iterator[Step]:
    """Show a progress bar and give the function that advances it. Nothing is shown where stderr is no terminal."""
    if not label or not sys.stderr.isatty():
        yield lambda: None
        return
    from rich.console import Console  # slow to load, and only a terminal needs it
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        line = bar.add_task(label, total=total)
        yield lambda: bar.advance(line)


def _in_turn(work: Callable[[T], R], task: T, step: Step) -> R | Failure:
    result = _attempted(work, task)
    step()
    return result


def _attempted(work: Callable[[T], R], task: T) -> R | Failure:
    try:
        return work(task)
    except Exception as error:  # any error: it is reported, and the other tasks go on
        return Failure.of(error)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Limit the numerical libraries to one thread, also in processes started inside.

    Every core already has a flight, so more threads would only compete.
    """
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
