"""Child processes that compute for the page, each warm and with limits.

A newer question ends the process of an older one.
"""

import asyncio
import multiprocessing
import signal
import time
from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing, suppress
from dataclasses import dataclass
from importlib import import_module
from multiprocessing.connection import Connection
from typing import Any

from pitotbench.browser.work import NEEDED
from pitotbench.records import error_words
from pitotbench.records.process import limit_process

_DONE = "done"
_LOST = "the computation was ended by the system, probably for its memory: use fewer minutes"
_TOO_LONG = "no answer within {} s of processor time: use fewer minutes, or a log of fewer rows"


@dataclass(frozen=True, slots=True)
class Limits:
    """What a child may use: bytes of addresses, and seconds of processor time for one question."""

    memory: int = 4 << 30
    seconds: int = 300


def serve(pipe: Connection, limits: Limits) -> None:
    """Answer questions from a pipe until it is closed. The target of a child process."""
    # Ctrl-C is for the server, which ends its children.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    limit_process("RLIMIT_AS", limits.memory)
    for name in NEEDED:
        import_module(name)

    def tell(name: str, reply: object) -> None:
        pipe.send((name, reply))

    with suppress(EOFError, OSError):
        tell(_DONE, None)
        while True:
            function, arguments = pipe.recv()
            limit_process("RLIMIT_CPU", int(time.process_time()) + limits.seconds)
            try:
                function(tell, *arguments)
            except Exception as error:
                tell("refusal", error_words(error))
            tell(_DONE, None)


class Child:
    """A process that answers one question at a time."""

    def __init__(self, limits: Limits) -> None:
        # Of a fresh interpreter, which holds no socket of the server; where the system can, of one
        # that has loaded what is needed.
        if "forkserver" in multiprocessing.get_all_start_methods():
            context: Any = multiprocessing.get_context("forkserver")
            context.set_forkserver_preload([*NEEDED])
        else:
            context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=serve, args=(theirs, limits), daemon=True)
        self._process.start()
        theirs.close()

    async def hear(self) -> Any:
        """Return what the child says next. Raises EOFError or OSError where it has ended."""
        return await asyncio.to_thread(self._pipe.recv)

    async def replies(
        self, function: Callable[..., Any], arguments: tuple[Any, ...]
    ) -> AsyncGenerator[Any, None]:
        """Yield the replies to a question with their names. Raises as `hear` does."""
        self._pipe.send((function, arguments))
        while (reply := await self.hear())[0] != _DONE:
            yield reply

    def end(self, wait: float = 0.0) -> int | None:
        """End the process; return what it had ended with by itself, None where it ran."""
        self._process.join(wait)
        code: int | None = self._process.exitcode
        self._process.kill()
        self._process.join()
        return code


class Workers:
    """Some children. Who has answered last is asked first: it remembers the log."""

    def __init__(self, count: int = 2, limits: Limits | None = None) -> None:
        self.limits = limits or Limits()
        self._idle: asyncio.LifoQueue[Child] = asyncio.LifoQueue()
        self._children: dict[Child, asyncio.Task[None]] = {}
        for _ in range(count):
            self._start()

    def _start(self) -> None:
        child = Child(self.limits)

        async def join() -> None:
            with suppress(EOFError, OSError):  # one that has ended tells so when it is asked
                await child.hear()
            self._idle.put_nowait(child)

        self._children[child] = asyncio.ensure_future(join())

    async def ask(self, function: Callable[..., Any], *arguments: Any) -> AsyncGenerator[Any, None]:
        """Yield the replies to a question, a function of `work`, with their names.

        Whoever stops listening, or is canceled, ends the child; another takes its place.
        """
        child, answered = await self._idle.get(), False
        try:
            async with aclosing(child.replies(function, arguments)) as replies:
                async for reply in replies:
                    yield reply
            answered = True
        except (EOFError, OSError):
            late = child.end(wait=1.0) == -getattr(signal, "SIGXCPU", 0)
            yield "refusal", _TOO_LONG.format(self.limits.seconds) if late else _LOST
        finally:
            if answered:
                self._idle.put_nowait(child)
            elif self._children.pop(child, None) is not None:
                child.end()
                self._start()

    def close(self) -> None:
        """End all children."""
        children, self._children = self._children, {}
        for child in children:
            child.end()
