"""Run many flights, the one way: in this process, in spawned processes, or on a cluster.

A task is whatever is done with one flight. Results come in the order of the tasks, whatever the order in which they
end, and they are the same bit for bit however many processes share the work.
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

    `kind` is what `require_all` raises for it. `trace` is the traceback of an error that no rule of the domain
    foresees.
    """

    reason: str
    kind: type[Exception] = RuntimeError
    trace: str = ""

    @classmethod
    def of(cls, error: BaseException) -> "Failure":
        """The failure of an error, whose type is named where no rule of the domain foresees it.

        The error itself is not kept: not every error survives the way from one process to another.
        """
        for kind in _EXPECTED:
            if isinstance(error, kind):
                return cls(str(error), kind)
        return cls(f"{type(error).__name__}: {error}", trace="".join(format_exception(error)))


@dataclass(frozen=True, slots=True)
class Fleet:
    """Performs tasks through an executor, or in this process where that is None."""

    executor: Executor | None = None

    def perform(self, work: Callable[[T], R], tasks: Sequence[T], step: Step = lambda: None) -> list[R | Failure]:
        """The result of `work` for every task, in the order given; `step` is called after each.

        A task that raises gives a Failure and the others are not lost. With an executor `work` and the tasks have
        to be picklable.
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
    """Open a fleet, perform the tasks and close it: `jobs` processes, by default one a core and no more than tasks.

    `label` names a progress bar; without it there is none. Raises BadInputError as `open_fleet` does.
    """
    with open_fleet(jobs, scheduler, len(tasks)) as fleet, progress(label, len(tasks)) as advance:

        def after_each() -> None:
            advance()
            step()

        return fleet.perform(work, tasks, after_each)


def require_all(results: Sequence[R | Failure]) -> list[R]:
    """The results, where no task failed; else the first failure is raised as an error of its kind."""
    for result in results:
        if isinstance(result, Failure):
            raise result.kind(f"{result.reason}\n{result.trace}".rstrip())
    return [result for result in results if not isinstance(result, Failure)]


@contextmanager
def open_fleet(jobs: int | None = None, scheduler: str | None = None, tasks: int | None = None) -> Iterator[Fleet]:
    """This process for one job, spawned processes for more, a dask cluster for a scheduler's address.

    Without `jobs` there is a process a core, and no more than `tasks`.
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
        except BaseException:  # an interrupt as well: what has not begun is not waited for
            pool.shutdown(wait=False, cancel_futures=True)
            raise


@contextmanager
def progress(label: str, total: int) -> Iterator[Step]:
    """A progress bar on standard error, and the function that advances it; quiet when that is not a terminal."""
    if not label or not sys.stderr.isatty():
        yield lambda: None
        return
    from rich.console import Console  # slow to load, and needed on a terminal alone
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
    except Exception as error:  # whatever it is, it is reported and the other tasks are kept
        return Failure.of(error)


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
