"""Run many flights: in this process, in spawned processes, or on a dask cluster."""

import faulthandler
import os
import socket
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from io import UnsupportedOperation
from itertools import islice
from multiprocessing import current_process
from pathlib import Path
from queue import SimpleQueue
from traceback import format_exception
from typing import Any, TypeVar

from pitotbench.campaigns.cluster import open_cluster
from pitotbench.campaigns.progress import Step, progress
from pitotbench.campaigns.worker_pool import LostWorkError, WorkerPool
from pitotbench.catalog import UnknownNameError
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.process import limit_process

T = TypeVar("T")
R = TypeVar("R")

MOST_LOST_AT_FIRST = 10  # processes that die before any task has ended: no worker works
MOST_IN_BUNDLE = 16  # tasks that are submitted as one call, however short they are
# tasks submitted for each worker of a cluster: one that flies, one that waits there, one on its way
_AHEAD = 3
# s of flights in one call: the scheduler and the driver spend 10 ms of CPU on each call
_BUNDLE = 1.0
_EXPECTED = (BadInputError, NoAnswerError, UnknownNameError)


class MachineError(BadInputError):
    """A task failed by its machine (a file is gone, the disk is full), and may be done again."""


class FleetLostError(RuntimeError):
    """The executor cannot be used any longer; another one can perform the tasks not done."""


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a task gave no result, in words.

    `kind` is the type of the error that `require_all` raises for it. `trace` is the traceback, or
    the last lines of the log of a process that died; it is empty for an error that the bench
    expects. `quarantined` is true for a task that ended its process, or that broke the limits of
    time or memory.
    """

    reason: str
    kind: type[Exception] = RuntimeError
    trace: str = ""
    quarantined: bool = False

    def __str__(self) -> str:
        return self.reason

    @classmethod
    def of(cls, error: BaseException) -> "Failure":
        """Return the failure that describes an error, by its type if the bench does not expect it.

        The error itself is not kept, because not every error can be sent from one process to
        another.
        """
        for kind in _EXPECTED:
            if isinstance(error, kind):
                return cls(str(error), kind)
        if isinstance(error, OSError):
            return cls(f"{error.filename or 'file'}: {error.strerror or error}", MachineError)
        return cls(f"{type(error).__name__}: {error}", trace="".join(format_exception(error)))


def require_all(results: Sequence[R | Failure]) -> list[R]:
    """Return the results, or raise the first failure as an error of its kind."""
    for result in results:
        if isinstance(result, Failure):
            raise result.kind(f"{result.reason}\n{result.trace}".rstrip())
    return [result for result in results if not isinstance(result, Failure)]


def _here() -> tuple[str, int]:
    return socket.gethostname(), os.getpid()


@dataclass(frozen=True, slots=True)
class Limits:
    """The most that one task may use: `seconds` of wall time, `memory` bytes of its process.

    None is no limit. The limits do not hold in the process of the driver, since a task that breaks
    the limit of time ends its process.
    """

    seconds: float | None = None
    memory: int | None = None
    driver: tuple[str, int] = field(default_factory=_here)

    @contextmanager
    def hold(self) -> Iterator[None]:
        """Hold the limits within the context.

        After the time the process writes where it is and ends. The memory is that of data
        (RLIMIT_DATA): an allocation above it raises MemoryError, or ends the process where a
        library does not expect that.
        """
        with ExitStack() as undone:
            if self.driver != _here():
                if self.memory is not None:
                    undone.callback(limit_process("RLIMIT_DATA", self.memory))
                if self.seconds is not None:
                    # Its thread is not one of Python: it also ends a process that is stuck inside
                    # the simulator.
                    faulthandler.dump_traceback_later(self.seconds, exit=True, file=_log())
                    undone.callback(faulthandler.cancel_dump_traceback_later)
            yield


def _log() -> int:
    """Return the descriptor of standard error, also where `sys.stderr` is no file."""
    with suppress(AttributeError, OSError, UnsupportedOperation):
        return sys.stderr.fileno()
    return 2


@dataclass(frozen=True, slots=True)
class Fleet:
    """Performs tasks through an executor, or in this process where the executor is None.

    A task is all the work on one flight. A task that fails is reported in words and the other tasks
    go on. A task whose process dies is performed once more, alone, and is then put in quarantine.

    `window` is the number of calls that are submitted at a time; it should be somewhat above the
    number of workers. A call is one task, or as many as take some `bundle` seconds together, where
    each call costs the executor much. `own_process` is for an executor that does not say why a
    process died: a task that lost its process is then performed again in a process that its
    worker starts and watches.
    """

    executor: Executor | None = None
    limits: Limits = field(default_factory=Limits)
    window: int = 64
    own_process: bool = False
    bundle: float = 0.0

    def stream(self, work: Callable[[T], R], tasks: Iterable[T]) -> Iterator[tuple[T, R | Failure]]:
        """Give each task with its result, in the order in which they end.

        `tasks` is read only as far as needed. A task that raises an error gives a Failure, and the
        other tasks go on. A task whose process dies, or which its machine fails, is performed once
        more at the end, while no other task runs; where its process dies again, the task is in
        quarantine: its Failure says so. With an executor, `work` and the tasks must be picklable.
        Raises FleetLostError where the executor has ended, and where one task after another is
        lost.
        """
        lost: list[T] = []
        ended, failed_in_a_row = False, 0
        for task, result in self._attempts(attempt, work, tasks, self.window, self.bundle):
            by_machine = isinstance(result, Failure) and result.kind is MachineError
            failed_in_a_row = failed_in_a_row + 1 if by_machine else 0
            if by_machine or isinstance(result, LostWorkError):
                lost.append(task)
                if max(failed_in_a_row, 0 if ended else len(lost)) >= MOST_LOST_AT_FIRST:
                    log = getattr(result, "log", "")
                    raise FleetLostError(f"no worker can work: {result}\n{log}".rstrip())
                continue
            ended = True
            yield task, result
        again = attempt_in_own_process if self.own_process else attempt
        # Each in a call of its own: one that dies again takes no other with it.
        for task, result in self._attempts(again, work, lost, window=1, bundle=0.0):
            if isinstance(result, LostWorkError):
                yield task, Failure(f"{result}, twice", LostWorkError, result.log, quarantined=True)
            else:
                yield task, result

    def perform(
        self, work: Callable[[T], R], tasks: Sequence[T], step: Step = lambda: None
    ) -> list[R | Failure]:
        """Return the result of `work` for every task, in their order.

        `step` is called after each task.
        """
        done: dict[int, R | Failure] = {}
        numbered: Iterator[tuple[tuple[int, T], R | Failure]] = self.stream(
            partial(_numbered, work), list(enumerate(tasks))
        )
        for (place, _), result in numbered:
            done[place] = result
            step()
        return [done[place] for place in range(len(tasks))]

    def _attempts(
        self,
        try_it: Callable[..., Any],
        work: Callable[[T], R],
        tasks: Iterable[T],
        window: int,
        bundle: float,
    ) -> Iterator[tuple[T, R | Failure | LostWorkError]]:
        if self.executor is None:
            for task in tasks:
                yield task, try_it(work, self.limits, task)
            return
        source, running = iter(tasks), dict[Future[Any], list[T]]()
        ended: SimpleQueue[Future[Any]] = SimpleQueue()
        done, spent, size = 0, 0.0, 1
        while True:
            while len(running) < window and (several := [*islice(source, size)]):
                try:
                    future = self.executor.submit(attempt_each, try_it, work, self.limits, several)
                except (BrokenExecutor, RuntimeError) as error:
                    raise FleetLostError(f"the executor takes no more tasks: {error}") from error
                running[future] = several
                future.add_done_callback(ended.put)
            if not running:
                return
            over = ended.get()
            several, outcome = running.pop(over), _outcome(over)
            if isinstance(outcome, (Failure, LostWorkError)):
                yield from ((task, outcome) for task in several)
                continue
            results, seconds = outcome
            done, spent = done + len(results), spent + seconds
            size = max(1, min(MOST_IN_BUNDLE, int(bundle * done / spent))) if spent > 0.0 else 1
            yield from zip(several, results, strict=True)


def _numbered(work: Callable[[T], R], task: tuple[int, T]) -> R:
    """Do the work on a task that carries its place."""
    return work(task[1])


def _outcome(future: "Future[Any]") -> Any:
    """Return the result of a future that has ended, or the failure of its process.

    `attempt` catches every error of a task, so one that arrives here means that the process died.
    """
    try:
        error = future.exception()
    except CancelledError as cancelled:
        raise FleetLostError("the executor has cancelled its tasks") from cancelled
    if error is None:
        return future.result()
    if isinstance(error, LostWorkError):
        return error
    if isinstance(error, BrokenExecutor):
        raise FleetLostError(f"{type(error).__name__}: {error}") from error
    if type(error).__name__ == "KilledWorker":  # of dask, which is not imported without a scheduler
        return LostWorkError("dask: its worker died")
    if type(error).__name__ in ("FutureCancelledError", "CommClosedError"):
        raise FleetLostError(f"the scheduler is gone: {error}") from error
    return Failure.of(error)


def attempt(work: Callable[[T], R], limits: Limits, task: T) -> R | Failure:
    """Return the result of a task within its limits, or the Failure of any error.

    This runs in any process.
    """
    try:
        with limits.hold():
            return work(task)
    except MemoryError as error:
        limit = "" if limits.memory is None else f"its limit of {limits.memory / 1e9:g} GB of "
        return Failure(
            f"it needs more than {limit}memory ({error})".replace(" ()", ""), quarantined=True
        )
    except Exception as error:  # any error: it is reported, and the other tasks go on
        return Failure.of(error)


def attempt_each(
    try_it: Callable[..., R | Failure], work: Callable[[T], R], limits: Limits, tasks: Sequence[T]
) -> tuple[list[R | Failure], float]:
    """Attempt tasks one after the other; return their results, and how long they took [s]."""
    begun = time.monotonic()
    results = [try_it(work, limits, task) for task in tasks]
    return results, time.monotonic() - begun


def attempt_in_own_process(work: Callable[[T], R], limits: Limits, task: T) -> R | Failure:
    """Attempt a task in a new process that this one starts.

    Raises LostWorkError, with its log, where that dies.
    """
    current_process().daemon = False  # workers of dask are daemons, which may start no process
    pool = WorkerPool(1, limits.seconds)
    try:
        found: R | Failure = pool.submit(attempt, work, limits, task).result()
        return found
    finally:
        pool.shutdown(cancel_futures=True)


def run_tasks(
    work: Callable[[T], R],
    tasks: Sequence[T],
    jobs: int | None = None,
    scheduler: str | None = None,
    label: str = "",
    step: Step = lambda: None,
) -> list[R | Failure]:
    """Open a fleet, perform the tasks and close the fleet.

    `jobs` is the number of processes, by default one for each core and no more than there are
    tasks. `label` names a progress bar; without it there is no bar. Raises BadInputError as
    `open_fleet` does.
    """
    with open_fleet(jobs, scheduler, len(tasks)) as fleet, progress(label, len(tasks)) as advance:

        def after_each() -> None:
            advance()
            step()

        return fleet.perform(work, tasks, after_each)


@contextmanager
def open_fleet(
    jobs: int | None = None,
    scheduler: str | None = None,
    tasks: int | None = None,
    limits: Limits | None = None,
    security: Path | None = None,
    isolated: bool = False,
) -> Iterator[Fleet]:
    """Open a fleet: this process for one job, spawned processes for more, or a dask cluster.

    The cluster is that of a scheduler's address. Without `jobs` there is one process for each core,
    and no more than `tasks`. With `isolated` one job is a process of its own as well, so that a
    flight that crashes does not end this one. One task is performed here; so is all work where this
    process may start no other. `security` is a file with the certificates of a `tls://` scheduler.
    Raises BadInputError where dask is not installed, the scheduler does not answer or a worker does
    not fit.
    """
    limits = limits or Limits()
    if scheduler is not None:
        with open_cluster(scheduler, security) as (executor, workers):
            yield Fleet(
                executor, limits, max(_AHEAD * workers, 8), own_process=True, bundle=_BUNDLE
            )
        return
    processes = jobs or usable_cores()
    if tasks is not None:
        processes = min(processes, max(tasks, 1)) if jobs is None or isolated else processes
    # A worker of a multiprocessing.Pool may not start processes of its own.
    if current_process().daemon or (processes <= 1 and not (isolated and tasks != 1)):
        yield Fleet(limits=limits)
        return
    pool = WorkerPool(processes, limits.seconds)
    try:
        yield Fleet(pool, limits, window=2 * processes)
        pool.shutdown()
    finally:  # after an error or an interrupt: do not wait for any task
        pool.shutdown(cancel_futures=True)


def usable_cores() -> int:
    """Return the number of cores that this process may use, which a batch system can limit."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # only Linux says so
        return os.cpu_count() or 1
