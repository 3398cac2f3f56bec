"""Open a fleet: this process, spawned processes, or a dask cluster."""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import TypeVar

from pitotbench.bench.fleet.failure import Failure
from pitotbench.bench.fleet.saying import say
from pitotbench.bench.fleet.task_limits import Limits
from pitotbench.bench.fleet.task_stream import Fleet, Step
from pitotbench.bench.fleet.worker_pool import WorkerPool

T = TypeVar("T")
R = TypeVar("R")
_EVERY = 20.0  # s between two lines


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


@contextmanager
def open_fleet(
    jobs: int | None = None,
    scheduler: str | None = None,
    tasks: int | None = None,
    limits: Limits | None = None,
    security: Path | None = None,
    isolated: bool = False,
) -> Iterator[Fleet]:
    """Give a fleet: this process for one job, spawned processes for more, a dask cluster for a scheduler's address.

    Without `jobs` there is one process for each core, and no more than `tasks`. With `isolated` one job is a
    process of its own as well, so that a flight that crashes does not end this one. One task is performed here.
    `security` is a file with the certificates of a `tls://` scheduler.
    Raises BadInputError where dask is not installed, the scheduler does not answer or a worker does not fit.
    """
    limits = limits or Limits()
    if scheduler is not None:
        from pitotbench.bench.fleet.cluster import open_cluster

        with open_cluster(scheduler, limits, security) as fleet:
            yield fleet
        return
    processes = jobs or usable_cores()
    if tasks is not None:
        processes = min(processes, max(tasks, 1)) if jobs is None or isolated else processes
    if processes <= 1 and not (isolated and tasks != 1):
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
    except AttributeError:  # only Linux tells
        return os.cpu_count() or 1


@contextmanager
def progress(label: str, total: int) -> Iterator[Step]:
    """Show a progress bar and give the function that advances it.

    Where stderr is no terminal a line is written instead, every 20 s at most. Without a label nothing is shown.
    """
    if not label:
        yield lambda: None
        return
    if not sys.stderr.isatty():
        yield _lines(label, total)
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


def _lines(label: str, total: int) -> Step:
    done, said = 0, monotonic()

    def advance() -> None:
        nonlocal done, said
        done += 1
        if monotonic() - said >= _EVERY:
            said = monotonic()
            say(f"{label}: {done:,} of {total:,}")

    return advance
