"""An executor of spawned processes, in which a process that dies takes no other task with it."""

import os
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import wait
from multiprocessing.reduction import ForkingPickler
from threading import Lock, Thread
from typing import Any

from pitotbench.bench.fleet.failure import LostWorkError
from pitotbench.bench.fleet.task_limits import TIME_OVER
from pitotbench.bench.fleet.worker_process import BEGUN, serve

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_LOG_KEPT = 8192  # bytes of what a process wrote last
_GRACE = 30.0  # s after the limit of time, within which a process should have ended itself
_START = 300.0  # s within which a process should have started and loaded its modules
_SPAWN = get_context("spawn")
_UNGUARDED = (
    "Each process loads the script that started it: put what the script does below the line "
    'if __name__ == "__main__":'
)


@dataclass(slots=True)
class _Call:
    future: "Future[Any]"
    message: bytes


class _Worker:
    """One spawned process, the connection to it and the end of its log."""

    def __init__(self) -> None:
        self.calls, theirs = _SPAWN.Pipe()
        self.log, log = _SPAWN.Pipe(duplex=False)
        with _one_thread():
            self.process = _SPAWN.Process(target=serve, args=(theirs, log, os.getpid()))
            self.process.start()
        theirs.close()
        log.close()
        os.set_blocking(self.log.fileno(), False)
        self.call: _Call | None = None
        self.begun = 0.0
        self.loaded = False  # whether it has taken a call
        self.text = b""

    def begin(self, call: _Call) -> None:
        self.call, self.begun, self.text = call, time.monotonic() + _START, b""
        with suppress(OSError):  # it has died: its end is noticed with the next look
            self.calls.send_bytes(call.message)

    def read_log(self) -> bool:
        """Read what the process has written. Return whether there can be more."""
        try:
            new = os.read(self.log.fileno(), 65536)
        except BlockingIOError:
            return True
        except OSError:
            return False
        self.text = (self.text + new)[-_LOG_KEPT:]
        return bool(new)

    def end(self) -> None:
        """Kill the process and close the connections."""
        self.process.kill()
        self.process.join()
        self.calls.close()
        self.log.close()
        self.process.close()


@dataclass(slots=True)
class _State:
    """What the threads of a pool share."""

    waiting: deque[_Call] = field(default_factory=deque)
    closing: bool = False
    lock: Lock = field(default_factory=Lock)


class WorkerPool(Executor):
    """Performs calls in `count` spawned processes, one call at a time in each.

    The processes are started when they are needed, and end with this process, however it ends. A call whose process
    dies raises LostWorkError, and the next call gets a new process; where a process cannot even load its modules,
    the call raises BrokenExecutor. A call that takes longer than `seconds` should
    have ended its process itself (`Limits`); half a minute later the process is killed.
    """

    def __init__(self, count: int, seconds: float | None = None) -> None:
        self._count = count
        self._longest = None if seconds is None else seconds + _GRACE
        self._seconds = seconds
        self._state = _State()
        self._workers: list[_Worker] = []
        self._wake, self._woken = os.pipe()[::-1]
        # On Linux a process can end with the thread that started it, so one thread that stays starts them all.
        self._thread = Thread(target=self._serve, name="worker pool", daemon=True)
        self._thread.start()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        """Return the future of a call. Raises RuntimeError after `shutdown`, and what pickling raises."""
        future: Future[Any] = Future()
        call = _Call(future, bytes(ForkingPickler.dumps((fn, args, kwargs))))
        with self._state.lock:
            if self._state.closing:
                raise RuntimeError("the pool of workers is closed")
            self._state.waiting.append(call)
        os.write(self._wake, b".")
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes: after the calls that were submitted, or at once where they are cancelled."""
        with self._state.lock:
            first = not self._state.closing
            self._state.closing = True
            if cancel_futures:
                dropped = [*self._state.waiting]
                self._state.waiting.clear()
                for worker in self._workers:
                    with suppress(ValueError):  # it is closed already
                        worker.process.kill()
                for call in dropped:
                    call.future.cancel()
        if first:
            os.write(self._wake, b".")
        if wait or cancel_futures:
            self._thread.join()

    def pids(self) -> list[int]:
        """Return the processes that are alive."""
        return [worker.process.pid for worker in [*self._workers] if worker.process.pid]

    def _serve(self) -> None:
        """Give calls to workers and take their results, until the pool is closed. This is the pool's own thread."""
        try:
            while not self._done():
                self._hand_out()
                self._listen()
        finally:
            for worker in self._workers:
                if worker.call is not None:
                    _settle(worker.call.future, error=LostWorkError("the pool of workers was closed"))
                worker.end()
            self._workers.clear()
            os.close(self._woken)

    def _done(self) -> bool:
        with self._state.lock:
            busy = self._state.waiting or any(worker.call for worker in self._workers)
            return self._state.closing and not busy

    def _hand_out(self) -> None:
        while True:
            idle = next((worker for worker in self._workers if worker.call is None), None)
            with self._state.lock:
                if not self._state.waiting or (idle is None and len(self._workers) >= self._count):
                    return
                call = self._state.waiting.popleft()
            if not call.future.set_running_or_notify_cancel():
                continue
            if idle is None:
                try:
                    idle = _Worker()
                except (OSError, RuntimeError) as error:
                    # RuntimeError: this is a process of another pool, which has not loaded its modules yet.
                    reason = _UNGUARDED if isinstance(error, RuntimeError) else f"no process starts: {error}"
                    _settle(call.future, error=BrokenExecutor(reason))
                    continue
                with self._state.lock:
                    self._workers.append(idle)
            idle.begin(call)

    def _listen(self) -> None:
        sources: dict[Any, _Worker | None] = {self._woken: None}
        for each in self._workers:
            sources |= {each.calls: each, each.log: each, each.process.sentinel: each}
        for source in wait([*sources], self._patience()):
            worker = sources[source]
            if worker is None:
                os.read(self._woken, 4096)
            elif worker not in self._workers:
                continue  # its end was noticed by another of its connections
            elif source is worker.log:
                worker.read_log()
            elif source is worker.calls:
                self._take(worker)
            elif not worker.calls.poll():
                self._bury(worker)
        self._end_late()

    def _take(self, worker: _Worker) -> None:
        try:
            message = worker.calls.recv_bytes()
            if message == BEGUN:
                worker.begun, worker.loaded = time.monotonic(), True
                return
            good, value = ForkingPickler.loads(message)
        except (EOFError, OSError):
            self._bury(worker)
            return
        except Exception as error:  # a result that cannot be rebuilt here
            good, value = False, error
        call, worker.call = worker.call, None
        if call is not None:
            _settle(call.future, *((value, None) if good else (None, value)))

    def _bury(self, worker: _Worker, reason: str = "") -> None:
        """Remove a process that died, and fail its call with what it wrote last."""
        worker.process.join(1.0)
        while worker.log.poll() and worker.read_log():
            pass
        log = worker.text.decode(errors="replace").strip()
        reason = reason or self._reason(worker, log)
        with self._state.lock:
            self._workers.remove(worker)
            closing = self._state.closing
        failed = not worker.loaded and (worker.process.exitcode or 0) > 0
        worker.end()
        if worker.call is None:
            return
        if failed and not closing:
            error: Exception = BrokenExecutor(f"{reason} while it was loading. {_UNGUARDED}\n{log}".rstrip())
        else:
            error = LostWorkError("the pool was closed" if closing else reason, log)
        _settle(worker.call.future, error=error)

    def _reason(self, worker: _Worker, log: str) -> str:
        if self._seconds is not None and TIME_OVER in log:
            return f"it took longer than its limit of {self._seconds:g} s"
        code = worker.process.exitcode
        how = f"signal {-code}" if code is not None and code < 0 else f"exit code {code}"
        return f"its process ended ({how})"

    def _patience(self) -> float | None:
        """Return the time until the next call is late [s]; None where no call can be."""
        if self._longest is None:
            return None
        begun = [worker.begun for worker in self._workers if worker.call is not None]
        return max(0.0, min(begun) + self._longest - time.monotonic()) if begun else None

    def _end_late(self) -> None:
        if self._longest is None:
            return
        for worker in [*self._workers]:
            if worker.call is not None and time.monotonic() - worker.begun > self._longest:
                worker.process.kill()
                self._bury(worker, f"it took longer than its limit of {self._seconds:g} s and did not end")


def _settle(future: "Future[Any]", value: Any = None, error: BaseException | None = None) -> None:
    if error is not None:
        future.set_exception(error)
    else:
        future.set_result(value)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Limit the numerical libraries of the processes that are started inside to one thread.

    Every core already has a flight, so more threads would only compete.
    """
    before = {variable: os.environ.get(variable) for variable in _THREADS}
    os.environ.update({variable: "1" for variable, value in before.items() if value is None})
    try:
        yield
    finally:
        for variable in (name for name, value in before.items() if value is None):
            os.environ.pop(variable, None)
