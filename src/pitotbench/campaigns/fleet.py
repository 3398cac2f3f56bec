"""Run many flights: in this process, in spawned processes, or on a dask cluster."""

import faulthandler
import os
import platform
import socket
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from importlib.metadata import version
from io import UnsupportedOperation
from itertools import islice
from multiprocessing import current_process
from pathlib import Path
from queue import SimpleQueue
from time import monotonic
from traceback import format_exception
from typing import TYPE_CHECKING, Any, TypeVar

from pitotbench.campaigns.worker_pool import LostWorkError, WorkerPool
from pitotbench.catalog import UnknownNameError
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.intake import read_toml
from pitotbench.records.process import limit_process

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

T = TypeVar("T")
R = TypeVar("R")
Step = Callable[[], None]

MOST_LOST_AT_FIRST = 10  # processes that die before any task has ended: no worker works
MOST_IN_BUNDLE = 16  # tasks that are submitted as one call, however short they are
_EXPECTED = (BadInputError, NoAnswerError, UnknownNameError)
_EVERY = 20.0  # s between two lines


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

    No limit where it is None.

    They do not hold in the process of the driver, since a task that breaks the limit of time ends
    its process.
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

    An error outside of `attempt` means that the process died.

    `attempt` catches all others.
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
        with open_cluster(scheduler, limits, security) as fleet:
            yield fleet
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


@contextmanager
def progress(label: str, total: int) -> Iterator[Step]:
    """Show a progress bar and give the function that advances it.

    No bar without a label; no terminal on stderr gets a line instead, every 20 s at most.
    """
    if not label:
        yield lambda: None
        return
    if not sys.stderr.isatty():
        done, said = 0, monotonic()

        def advance() -> None:
            nonlocal done, said
            done += 1
            if monotonic() - said >= _EVERY:
                said = monotonic()
                say(f"{label}: {done:,} of {total:,}")

        yield advance
        return
    bar, line = terminal_bar(label, total)
    with bar:
        yield lambda: bar.advance(line)


def terminal_bar(label: str, total: int) -> tuple["Progress", "TaskID"]:
    """Return a bar for a terminal, to be shown as a context, and its line."""
    from rich.console import Console  # slow to load, and only a terminal needs it
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    return bar, bar.add_task(label, total=total)


def say(text: str) -> None:
    """Write a line to standard error."""
    from pitotbench.show.columns import printable

    sys.stderr.write(f"pitotbench: {printable(text)}\n")
    sys.stderr.flush()


_ALIKE = ("pitotbench", "jsbsim", "numpy", "scipy")  # their versions can change a result
_AHEAD = 3  # tasks submitted for each worker: one that flies, one that waits at the worker, one on its way
# s of flights in one call: the scheduler and the driver spend 10 ms of CPU on each call
_BUNDLE = 1.0
_PATIENCE = 60.0  # s to wait for the first worker


@dataclass(frozen=True, slots=True)
class Host:
    """The versions of a process that is to fly for a campaign, and the digest of its code."""

    versions: Mapping[str, str]
    code: str


def describe_host() -> Host:
    """Return the versions and the code of this process."""
    from pitotbench.campaigns.digests import code_digest

    versions = {"python": platform.python_version()} | {name: version(name) for name in _ALIKE}
    return Host(versions, code_digest())


@contextmanager
def open_cluster(address: str, limits: Limits, security: Path | None = None) -> Iterator[Fleet]:
    """Give a fleet on the workers of a dask scheduler.

    Every worker must have the versions and the code of the driver, and one thread: this is checked
    before anything is flown.

    Raises BadInputError where dask is not installed, where the scheduler does not answer, where it
    has no worker within a minute, and where a worker has other versions, other code or more than
    one thread.
    """
    try:
        distributed: Any = import_module("distributed")
    except ImportError as error:
        raise BadInputError("--scheduler needs dask: pip install 'pitotbench[cluster]'") from error
    secured = _security(distributed, address, security)
    try:
        client = distributed.Client(address, timeout="10s", security=secured)
    except (OSError, ValueError, RuntimeError) as error:
        raise BadInputError(f"no dask scheduler answers at {address}: {error}") from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except TimeoutError as error:
            raise BadInputError(
                f"the scheduler at {address} has no worker; start one with `dask worker`"
            ) from error
        workers = client.scheduler_info(n_workers=-1)["workers"]
        _require_one_thread(workers)
        check_hosts(describe_host(), client.run(describe_host, on_error="return"))
        window = max(_AHEAD * len(workers), 8)
        yield Fleet(
            client.get_executor(pure=False), limits, window, own_process=True, bundle=_BUNDLE
        )


def check_hosts(here: Host, workers: Mapping[str, Host | Exception]) -> None:
    """Raise BadInputError for a worker that differs in a version or in the code.

    The message names the worker and the first difference.
    """
    for name, there in workers.items():
        if isinstance(there, BaseException):
            raise BadInputError(f"worker {name} cannot fly: {type(there).__name__}: {there}")
        for what, mine in here.versions.items():
            if there.versions.get(what) != mine:
                raise BadInputError(
                    f"worker {name} has {what} {there.versions.get(what)}, the driver has {mine}"
                )
        if there.code != here.code:
            raise BadInputError(
                f"worker {name} has other code or aircraft files than the driver; install the same"
            )


def _require_one_thread(workers: Mapping[str, Mapping[str, Any]]) -> None:
    for name, worker in workers.items():
        if worker["nthreads"] != 1:
            raise BadInputError(
                f"worker {name} has {worker['nthreads']} threads; a flight needs a process: "
                "start it with `dask worker --nthreads 1 --nworkers N`"
            )


def _security(distributed: Any, address: str, file: Path | None) -> Any:
    """Return dask's own record of the certificates that a TOML file names.

    A `tls://` scheduler asks for them.
    """
    if file is None:
        if address.startswith("tls"):
            raise BadInputError(
                f"{address} asks for certificates: give --security FILE with the paths ca, cert "
                "and key"
            )
        return None
    stated = read_toml(file, "the paths of certificates")
    try:
        ca, cert, key = (str(file.parent / stated[name]) for name in ("ca", "cert", "key"))
        security = distributed.Security(
            tls_ca_file=ca,
            tls_client_cert=cert,
            tls_client_key=key,
            require_encryption=address.startswith("tls"),
        )
        security.get_connection_args("client")  # reads the files
    except (OSError, ValueError, KeyError, TypeError) as error:
        why = f": {error.strerror}" if isinstance(error, OSError) and error.strerror else ""
        raise BadInputError(
            f"{file}: not a TOML file with the paths ca, cert and key of readable files{why}"
        ) from error
    return security
