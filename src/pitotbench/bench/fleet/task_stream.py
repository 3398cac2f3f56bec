"""Perform a stream of tasks through an executor, with a bounded number of them submitted at a time."""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from dataclasses import dataclass, field
from itertools import islice
from multiprocessing import current_process
from queue import SimpleQueue
from typing import Any, TypeVar

from pitotbench.bench.fleet.failure import Failure, FleetLostError, LostWorkError
from pitotbench.bench.fleet.task_limits import Limits
from pitotbench.bench.fleet.worker_pool import WorkerPool

T = TypeVar("T")
R = TypeVar("R")
Step = Callable[[], None]

MOST_LOST_AT_FIRST = 10  # processes that die before any task has ended: no worker works
MOST_IN_BUNDLE = 16  # tasks that are submitted as one call, however short they are


@dataclass(frozen=True, slots=True)
class Fleet:
    """Performs tasks through an executor, or in this process where the executor is None.

    `window` is the number of calls that are submitted at a time; it should be somewhat above the number of workers.
    A call is one task, or as many as take some `bundle` seconds together, where each call costs the executor much.
    `apart` is for an executor that does not tell why a process died: a task that lost its process is then performed
    again in a process that its worker starts and watches.
    """

    executor: Executor | None = None
    limits: Limits = field(default_factory=Limits)
    window: int = 64
    apart: bool = False
    bundle: float = 0.0

    def stream(self, work: Callable[[T], R], tasks: Iterable[T]) -> Iterator[tuple[T, R | Failure]]:
        """Give each task with its result, in the order in which they end.

        `tasks` is read only as far as needed. A task that raises an error gives a Failure, and the other tasks go
        on. A task whose process dies is performed once more at the end, while no other task runs; where its process
        dies again, the task is in quarantine: its Failure says so. With an executor, `work` and the tasks must be
        picklable. Raises FleetLostError where the executor has ended.
        """
        if self.executor is None:
            for task in tasks:
                yield task, attempt(work, self.limits, task)
            return
        lost: list[T] = []
        ended = False
        for task, result in self._attempts(self.executor, attempt, work, tasks, self.window):
            if isinstance(result, LostWorkError):
                lost.append(task)
                if not ended and len(lost) >= MOST_LOST_AT_FIRST:
                    raise FleetLostError(f"no worker can work: {result}\n{result.log}".rstrip())
                continue
            ended = True
            yield task, result
        again = attempt_apart if self.apart else attempt
        for task, result in self._attempts(self.executor, again, work, lost, 1):
            if isinstance(result, LostWorkError):
                yield task, Failure(f"{result}, twice", LostWorkError, result.log, quarantined=True)
            else:
                yield task, result

    def perform(self, work: Callable[[T], R], tasks: Sequence[T], step: Step = lambda: None) -> list[R | Failure]:
        """Return the result of `work` for every task, in their order. `step` is called after each task."""
        done: dict[int, R | Failure] = {}
        numbered: Iterator[tuple[tuple[int, T], R | Failure]] = self.stream(_Numbered(work), list(enumerate(tasks)))
        for (place, _), result in numbered:
            done[place] = result
            step()
        return [done[place] for place in range(len(tasks))]

    def _attempts(
        self,
        executor: Executor,
        try_it: Callable[..., Any],
        work: Callable[[T], R],
        tasks: Iterable[T],
        window: int,
    ) -> Iterator[tuple[T, R | Failure | LostWorkError]]:
        source, running = iter(tasks), dict[Future[Any], list[T]]()
        ended: SimpleQueue[Future[Any]] = SimpleQueue()
        done, spent, size = 0, 0.0, 1
        while True:
            while len(running) < window and (several := [*islice(source, size)]):
                try:
                    future = executor.submit(attempt_each, try_it, work, self.limits, several)
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
            size = max(1, min(MOST_IN_BUNDLE, int(self.bundle * done / spent))) if spent > 0.0 else 1
            yield from zip(several, results, strict=True)


@dataclass(frozen=True, slots=True)
class _Numbered:
    """The work on a task that carries its place."""

    work: Callable[..., Any]

    def __call__(self, task: tuple[int, Any]) -> Any:
        return self.work(task[1])


def _outcome(future: "Future[Any]") -> Any:
    """Return the result of a future that has ended. An error outside of `attempt` means that its process died."""
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
    """Return the result of a task within its limits, or the Failure of any error. This runs in any process."""
    try:
        with limits.hold():
            return work(task)
    except MemoryError as error:
        held = "" if limits.memory is None else f"its limit of {limits.memory / 1e9:g} GB of "
        return Failure(f"it needs more than {held}memory ({error})".replace(" ()", ""), quarantined=True)
    except Exception as error:  # any error: it is reported, and the other tasks go on
        return Failure.of(error)


def attempt_each(
    try_it: Callable[..., R | Failure], work: Callable[[T], R], limits: Limits, tasks: Sequence[T]
) -> tuple[list[R | Failure], float]:
    """Attempt tasks one after the other; return their results, and how long they took [s]."""
    begun = time.monotonic()
    results = [try_it(work, limits, task) for task in tasks]
    return results, time.monotonic() - begun


def attempt_apart(work: Callable[[T], R], limits: Limits, task: T) -> R | Failure:
    """Attempt a task in a new process that this one starts. Raises LostWorkError, with its log, where that dies."""
    current_process().daemon = False  # workers of dask are daemons, which may start no process
    pool = WorkerPool(1, limits.seconds)
    try:
        found: R | Failure = pool.submit(attempt, work, limits, task).result()
        return found
    finally:
        pool.shutdown(cancel_futures=True)
