"""An executor of spawned processes, in which a process that dies takes no other task with it.

Each process has its own pipe and a thread that watches it. A pool whose processes share a pipe
loses all of them where one is killed while it holds the lock of that pipe.
"""

import ctypes
import faulthandler
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from multiprocessing.reduction import ForkingPickler
from queue import Empty, SimpleQueue
from tempfile import mkstemp
from threading import Lock, Thread
from typing import Any

TIME_OVER = "Timeout ("  # how faulthandler begins its report
_BEGUN = b""  # sent when a call begins
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_LOG_KEPT = 8192  # bytes of what a process wrote last
_GRACE = 30.0  # s after the limit of time, within which a process should have ended itself
_START = 300.0  # s within which a process should have started and loaded its modules
_END_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)
_SPAWN = get_context("spawn")
_STARTING = Lock()  # held while the environment is that of a new process
_UNGUARDED = (
    "Each process loads the script that started it: put what the script does below the line "
    'if __name__ == "__main__":'
)


class LostWorkError(RuntimeError):
    """The process that performed a task has ended.

    `log` is the last part of what the process wrote.
    """

    def __init__(self, reason: str, log: str = "") -> None:
        super().__init__(reason)
        self.log = log


@dataclass(frozen=True, slots=True)
class _Call:
    future: "Future[Any]"
    message: bytes


class WorkerPool(Executor):
    """Performs calls in `count` spawned processes, one call at a time in each.

    The processes are started when they are needed, and end with this process, however it ends. A
    call whose process dies raises LostWorkError, and the next call gets a new process; where a
    process cannot even load its modules, the call raises BrokenExecutor. A call that takes longer
    than `seconds` should have ended its process itself (`Limits`); half a minute later the process
    is killed.
    """

    def __init__(self, count: int, seconds: float | None = None) -> None:
        self._seconds = seconds
        self._calls: SimpleQueue[_Call | None] = SimpleQueue()
        self._workers: list[_Worker] = []
        self._closing = self._dropping = False
        self._lock = Lock()
        # On Linux a process can end with the thread that started it, so each thread stays as long
        # as its process.
        self._threads = [
            Thread(target=self._serve, name="worker pool", daemon=True) for _ in range(count)
        ]
        for thread in self._threads:
            thread.start()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        """Return the future of a call.

        Raises RuntimeError after `shutdown`, and what pickling raises.
        """
        future: Future[Any] = Future()
        call = _Call(future, bytes(ForkingPickler.dumps((fn, args, kwargs))))
        with self._lock:
            if self._closing:
                raise RuntimeError("the pool of workers is closed")
            self._calls.put(call)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes after the calls that were submitted, or at once if cancelled."""
        with self._lock:
            if cancel_futures:
                self._dropping = True
                for worker in self._workers:
                    worker.process.kill()
                with suppress(Empty):
                    while True:
                        if call := self._calls.get_nowait():
                            call.future.cancel()
            if not self._closing or cancel_futures:
                for _ in self._threads:
                    self._calls.put(None)
            self._closing = True
        if wait or cancel_futures:
            for thread in self._threads:
                thread.join()

    def _serve(self) -> None:
        """Give calls to one worker and take their results, in a thread, until the pool closes."""
        worker: _Worker | None = None
        try:
            while call := self._calls.get():
                if not call.future.set_running_or_notify_cancel():
                    continue
                try:
                    # It was killed while it was idle.
                    if worker is not None and not worker.process.is_alive():
                        self._dismiss(worker)
                        worker = None
                    worker = worker or self._hire()
                    good, value = worker.perform(call.message, self._seconds)
                except (LostWorkError, BrokenExecutor) as error:
                    self._dismiss(worker)
                    worker = None
                    good, value = (
                        False,
                        LostWorkError("the pool was closed") if self._dropping else error,
                    )
                if good:
                    call.future.set_result(value)
                else:
                    call.future.set_exception(value)
        finally:
            self._dismiss(worker)

    def _hire(self) -> "_Worker":
        with self._lock:
            if self._dropping:
                raise LostWorkError("the pool was closed")
            worker = _Worker()
            self._workers.append(worker)
            return worker

    def _dismiss(self, worker: "_Worker | None") -> None:
        if worker is not None:
            with self._lock:
                self._workers.remove(worker)
                worker.end()


class _Worker:
    """One spawned process, the connection to it and the end of its log.

    Raises BrokenExecutor if none starts.
    """

    def __init__(self) -> None:
        self.calls, theirs = _SPAWN.Pipe()
        # A file, and no pipe: the pipes of Windows have no descriptors that a process could write
        # its standard output to.
        try:
            number, self._name = mkstemp(prefix="pitotbench-", suffix=".log")
        except OSError as error:
            raise BrokenExecutor(f"no process starts: {error}") from error
        self.log = os.fdopen(number, "rb+", buffering=0)
        self.process = _SPAWN.Process(target=_work, args=(theirs, self._name, os.getpid()))
        try:
            with _one_thread():
                self.process.start()
        except (OSError, RuntimeError) as error:
            self._close_log()
            # RuntimeError: this is a process of another pool, which has not loaded its modules yet.
            reason = (
                _UNGUARDED if isinstance(error, RuntimeError) else f"no process starts: {error}"
            )
            raise BrokenExecutor(reason) from error
        theirs.close()
        self.loaded = False  # whether it has taken a call

    def perform(self, message: bytes, seconds: float | None) -> tuple[bool, Any]:
        """Return (true, result) or (false, error) of a call.

        Raises LostWorkError or BrokenExecutor.
        """
        self.log.truncate(0)
        longest = None if seconds is None else seconds + _GRACE
        late = time.monotonic() + _START
        with suppress(OSError):  # it has died, as is noticed below
            self.calls.send_bytes(message)
        while True:
            left = None if longest is None else max(0.0, late - time.monotonic())
            ready = wait([self.calls, self.process.sentinel], left)
            if not ready:
                self.process.kill()
                raise self._lost(f"it took longer than its limit of {seconds:g} s and did not end")
            if self.calls in ready:
                try:
                    answer = self.calls.recv_bytes()
                    if answer == _BEGUN:
                        self.loaded, late = True, time.monotonic() + (longest or 0.0)
                        continue
                    good, value = ForkingPickler.loads(answer)
                    return bool(good), value
                except (EOFError, OSError):
                    raise self._lost(seconds=seconds) from None
                except Exception as error:  # a result that cannot be rebuilt here
                    return False, error
            if self.process.sentinel in ready and not self.calls.poll():
                raise self._lost(seconds=seconds)

    def end(self) -> None:
        """Kill the process and close the connections."""
        self.process.kill()
        self.process.join()
        self.calls.close()
        self._close_log()
        self.process.close()

    def _close_log(self) -> None:
        self.log.close()
        with suppress(OSError):  # the process has done it
            os.unlink(self._name)

    def _lost(self, reason: str = "", seconds: float | None = None) -> Exception:
        """Return the error of a call whose process has ended, with what the process wrote last."""
        self.process.join(1.0)
        self.log.seek(max(0, self.log.seek(0, os.SEEK_END) - _LOG_KEPT))
        log = self.log.read().decode(errors="replace").strip()
        code = self.process.exitcode
        if not reason and seconds is not None and TIME_OVER in log:
            reason = f"it took longer than its limit of {seconds:g} s"
        elif not reason:
            how = f"signal {-code}" if code is not None and code < 0 else f"exit code {code}"
            reason = f"its process ended ({how})"
        if not self.loaded and (code or 0) > 0:
            return BrokenExecutor(f"{reason} while it was loading. {_UNGUARDED}\n{log}".rstrip())
        return LostWorkError(reason, log)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Limit the numerical libraries of the process that is started inside to one thread.

    Every core already has a flight, so more threads would only compete.
    """
    with _STARTING:
        missing = {variable: "1" for variable in _THREADS if variable not in os.environ}
        os.environ.update(missing)
        try:
            yield
        finally:
            for variable in missing:
                del os.environ[variable]


def _work(calls: "Connection[Any, Any]", log: str, parent: int) -> None:
    """Perform calls as they arrive, and send results, until the driver ends.

    Everything that the process writes goes to the file `log`. `_BEGUN` is sent when a call begins,
    then its result as (true, value) or its error as (false, error).
    """
    _end_with(parent)
    # Ctrl-C goes to the whole group; the driver ends its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    written = os.open(log, os.O_WRONLY | os.O_APPEND)
    with suppress(OSError):  # nobody else needs its name; Windows keeps that of an open file
        os.unlink(log)
    for stream in (1, 2):
        os.dup2(written, stream)
    faulthandler.enable(file=2)
    with suppress(EOFError, OSError):  # the driver is gone
        while True:
            calls.send_bytes(_answer(calls.recv_bytes(), calls))
            sys.stdout.flush()


def _answer(call: bytes, calls: "Connection[Any, Any]") -> bytes:
    try:
        function, arguments, settings = ForkingPickler.loads(call)
        calls.send_bytes(_BEGUN)  # the modules are loaded: the time of the call begins
        return bytes(ForkingPickler.dumps((True, function(*arguments, **settings))))
    except Exception as error:
        try:
            text = bytes(ForkingPickler.dumps((False, error)))
            ForkingPickler.loads(text)
            return text
        except Exception:  # an error that cannot be sent, or not be rebuilt
            return bytes(
                ForkingPickler.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")))
            )


def _end_with(parent: int) -> None:
    """Make this process end with its parent, whatever either is doing."""
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_END_WITH_PARENT, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:  # the parent ended before
        os._exit(1)
    # For the other systems, and for a parent thread that Linux does not distinguish from a parent.
    Thread(target=_wait_for_end_of_parent, daemon=True).start()


def _wait_for_end_of_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
