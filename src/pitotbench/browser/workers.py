"""Child processes that compute for the page, each warm and with limits; a newer question ends the
process of an older one.
"""

import asyncio
import contextlib
import multiprocessing
import signal
from collections.abc import AsyncGenerator, Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from pitotbench.browser.work import Refusal, warm
from pitotbench.records import error_words

_READY = "ready"
_DONE = "done"


@dataclass(frozen=True, slots=True)
class Limits:
    """What a child may use: bytes of addresses, and seconds of processor time for one question."""

    memory: int = 4 << 30
    seconds: int = 300


def serve(pipe: Connection, limits: Limits) -> None:
    """Answer questions from a pipe until it is closed. The target of a child process."""
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C is for the server, which ends its children
    with suppress(ImportError):  # Windows has no such limits
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (limits.memory, limits.memory))
    warm()
    pipe.send(_READY)
    with suppress(EOFError, OSError):
        while True:
            function, arguments = pipe.recv()
            _limit_time(limits.seconds)
            for reply in _replies(function, arguments):
                pipe.send(reply)
            pipe.send(_DONE)


def _limit_time(seconds: int) -> None:
    """Give a question its processor time, beyond what this process has used."""
    with suppress(ImportError):
        import resource

        used = resource.getrusage(resource.RUSAGE_SELF)
        limit = int(used.ru_utime + used.ru_stime) + seconds
        resource.setrlimit(resource.RLIMIT_CPU, (limit, resource.RLIM_INFINITY))


def _replies(
    function: Callable[..., Iterator[object]], arguments: tuple[Any, ...]
) -> Iterator[Any]:
    try:
        yield from function(*arguments)
    except Exception as error:
        yield Refusal(error_words(error))


class Child:
    """A process that answers one question at a time."""

    def __init__(self, limits: Limits) -> None:
        # A fresh interpreter: it holds no socket of the server.
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=serve, args=(theirs, limits), daemon=True)
        self._process.start()
        theirs.close()

    async def ready(self) -> None:
        """Wait until the child has loaded what it needs, or has ended before."""
        with suppress(EOFError, OSError):
            await asyncio.to_thread(self._pipe.recv)

    async def replies(
        self, function: Callable[..., Any], arguments: tuple[Any, ...]
    ) -> AsyncGenerator[Any, None]:
        """Yield the replies to a question. Raises EOFError or OSError where the child ends."""
        self._pipe.send((function, arguments))
        while (reply := await asyncio.to_thread(self._pipe.recv)) != _DONE:
            yield reply

    def code(self) -> int | None:
        """Return what a process that has closed its pipe ended with; None where it still runs."""
        self._process.join(1)
        return self._process.exitcode

    def end(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.join()


class Workers:
    """Some children. Who has answered last is asked first: it remembers the log."""

    def __init__(self, count: int = 2, limits: Limits | None = None) -> None:
        self._limits = limits or Limits()
        self._children: set[Child] = set()
        self._idle: asyncio.LifoQueue[Child] = asyncio.LifoQueue()
        self._starts: set[asyncio.Task[None]] = set()
        for _ in range(count):
            self._start()

    def _start(self) -> None:
        child = Child(self._limits)
        self._children.add(child)

        async def join() -> None:
            await child.ready()
            self._idle.put_nowait(child)  # one that has ended tells so when it is asked

        task = asyncio.ensure_future(join())
        self._starts.add(task)
        task.add_done_callback(self._starts.discard)

    async def ask(self, function: Callable[..., Any], *arguments: Any) -> AsyncGenerator[Any, None]:
        """Yield the replies to a question, which is a generator function of `work`. Whoever stops
        to listen, or is canceled, ends the child; another takes its place.
        """
        child, answered = await self._idle.get(), False
        try:
            async with contextlib.aclosing(child.replies(function, arguments)) as replies:
                async for reply in replies:
                    yield reply
            answered = True
        except (EOFError, OSError):
            yield Refusal(self._lost(child))
        finally:
            if answered:
                self._idle.put_nowait(child)
            elif child in self._children:
                self._children.discard(child)
                child.end()
                self._start()

    def _lost(self, child: Child) -> str:
        if child.code() == -getattr(signal, "SIGXCPU", 0):
            return (
                f"no answer within {self._limits.seconds} s of processor time: use fewer minutes, "
                "or a log with fewer rows"
            )
        return "the computation was ended by the system, probably for its memory: use fewer minutes"

    def close(self) -> None:
        """End all children."""
        children, self._children = self._children, set()
        for child in children:
            child.end()
