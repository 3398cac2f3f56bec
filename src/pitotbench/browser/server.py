"""The server of the page: on 127.0.0.1, at a free port, until it is stopped or left."""

import asyncio
import json
import re
import signal
import time
from collections.abc import Awaitable, Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from http import HTTPStatus
from pathlib import Path
from secrets import token_urlsafe
from socket import socket
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.server.server import BaseServer
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop
from tornado.netutil import bind_sockets
from tornado.web import HTTPError, RequestHandler, StaticFileHandler

from pitotbench.browser.access import Access, Guarded
from pitotbench.browser.desk import Desk
from pitotbench.browser.page import open_document, own_folder
from pitotbench.browser.uploads import MOST_BYTES, Store, Upload
from pitotbench.browser.words import UNITS
from pitotbench.browser.work import SETTINGS, fields_of
from pitotbench.browser.workers import Workers
from pitotbench.records import BadInputError

_LOOPBACK = "127.0.0.1"
_TRIES = 50  # ports
_LEFT = 1800.0  # s after which a page that nobody looks at ends
_LOOK = 5.0  # s between looks whether somebody does


class Act(RequestHandler):
    """Takes a choice that was made on the page."""

    def post(self) -> None:
        try:
            act(self.settings["desk"], json.loads(self.request.body))
        except (LookupError, TypeError, ValueError, AttributeError, RecursionError) as error:
            raise HTTPError(HTTPStatus.BAD_REQUEST, reason="no choice of this page") from error


def act(desk: Desk, choice: dict[str, Any]) -> None:
    """Make a choice of the page. Raises one of the errors of a wrong type or value for another."""
    match choice:
        case {"what": "arrived", "drop": str(drop)}:
            desk.add_drop(drop)
        case {"what": "choose", "places": places}:
            desk.choose([int(place) for place in places])
        case {"what": "compare", "place": int(place)}:
            desk.compare(place)
        case {"what": "remove", "place": int(place)}:
            desk.remove(place)
        case {"what": "example"}:
            desk.add_example()
        case {"what": "flags", "flags": flags, "without": str(without)}:
            stated = {name: str(flags[name]).strip() for name in SETTINGS}
            spans = tuple(span.strip() for span in without.split(",") if span.strip())
            desk.change(**fields_of(stated), without=spans)
        case {"what": "show", "unit": unit, "leave_out": bool(leave_out)} if unit in UNITS:
            desk.units, desk.leave_out = replace(desk.units, speed=unit), leave_out
            desk.tell()
        case {"what": "map", "rows": rows}:
            desk.read_with([(str(ours).strip(), str(unit).strip()) for ours, unit in rows])
        case {"what": "legs", "card": str(card)}:
            desk.reduce(card)
        case _:
            raise ValueError("no choice of this page")


class Take(RequestHandler):
    """Gives a file to take away."""

    async def get(self, kind: str) -> None:
        found = await self.settings["desk"].take(kind)
        if found is None:
            raise HTTPError(HTTPStatus.NOT_FOUND, reason="there is no such file yet")
        name, text = re.sub(r"[^A-Za-z0-9_.-]", "-", found[0]), found[1]
        self.set_header("Content-Type", "application/octet-stream")
        self.set_header("Content-Disposition", f'attachment; filename="{name}"')
        self.finish(text)


class PageServer:
    """A running page. Close it at the end."""

    def __init__(
        self,
        port: int,
        workers: Workers | None = None,
        most: int = MOST_BYTES,
    ) -> None:
        sockets, self.port = free_port(port)
        self.access = Access(self.port, token_urlsafe(), token_urlsafe())
        self.desk = Desk(Store(), workers or Workers())
        show = FunctionHandler(lambda document: open_document(self.desk, document))
        self.guarded = Guarded(
            {"/": Application(show)},
            self.access,
            secret_key=token_urlsafe().encode(),
            sign_sessions=True,
            desk=self.desk,
            most=most,
            extra_patterns=[
                (r"/own/(page\.js|page\.css)", StaticFileHandler, {"path": own_folder()}),
                (r"/upload", Upload),
                (r"/act", Act),
                (r"/take/([a-z]+)", Take),
            ],
        )
        http = HTTPServer(self.guarded)
        http.add_sockets(sockets)
        self._server = BaseServer(IOLoop.current(), self.guarded, http)
        self._server.start()

    def is_seen(self) -> bool:
        """Whether a tab shows the page."""
        return any(session.connection_count for session in self._server.get_sessions("/"))

    async def until_left(
        self,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        """Wait until no tab has shown the page for half an hour, by a clock [s] and its pauses."""
        seen = clock()
        while clock() - seen < _LEFT:
            await sleep(_LOOK)
            if self.is_seen():
                seen = clock()

    def entrance(self) -> str:
        """Return the address of a private file that leads to the page.

        The arguments of a browser are seen by all who use the computer.
        """
        page = f'<meta http-equiv="refresh" content="0; url={self.access.address}">'
        return self.desk.store.write("open.html", page).path.as_uri()

    def close(self) -> None:
        """End the server and its children, and delete the files."""
        self._server.stop(wait=False)
        self.desk.close()


def free_port(port: int) -> tuple[list[socket], int]:
    """Return sockets on the first free port from `port` on, and its number.

    Raises BadInputError where none of the next 50 is free.
    """
    for number in range(port, port + _TRIES):
        with suppress(OSError):
            sockets = bind_sockets(number, _LOOPBACK)
            return sockets, sockets[0].getsockname()[1]
    raise BadInputError(f"the ports {port} to {port + _TRIES - 1} are taken: give another --port")


def _end_by_signals() -> None:
    """Let the task that runs end as by Ctrl-C when the system ends the program.

    The same where its terminal is closed: else the dropped files would stay.
    """
    task, loop = asyncio.current_task(), asyncio.get_running_loop()
    assert task is not None
    for name in ("SIGTERM", "SIGHUP"):
        with suppress(AttributeError, NotImplementedError):  # a loop of Windows takes no signals
            loop.add_signal_handler(getattr(signal, name), task.cancel)


def run_page(
    places: Sequence[Path], port: int, show: Callable[[str], bool], say: Callable[[str], None]
) -> None:
    """Serve the page with some files until it is left. `show` opens an address; `say` prints.

    Raises BadInputError where no port is free, KeyboardInterrupt where it is stopped.
    """

    async def serve() -> None:
        _end_by_signals()
        server = PageServer(port)
        try:
            if port not in (0, server.port):
                say(f"port {port} is taken: port {server.port} is used")
            say(f"open this page: {server.access.address}")
            say("It is on this computer alone. Ctrl-C ends it, or half an hour without a tab.")
            show(server.entrance())
            for place in places:
                server.desk.add(
                    place, {"": f"{place}/"} if place.is_dir() else {place.name: str(place)}
                )
            await server.until_left()
            say("nobody looked at the page for half an hour: it is closed")
        finally:
            server.close()

    with suppress(asyncio.CancelledError):
        asyncio.run(serve())
