"""The server of the page: on 127.0.0.1, at a free port, until it is stopped or left."""

import asyncio
import json
import time
from collections.abc import Callable, Sequence
from errno import EADDRINUSE
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
from tornado.web import RequestHandler

from pitotbench.browser.access import Access, Guarded
from pitotbench.browser.desk import FLAGS, Desk
from pitotbench.browser.page import open_document, own_file
from pitotbench.browser.uploads import MOST_BYTES, Store, Upload
from pitotbench.browser.words import UNITS
from pitotbench.browser.work import Refusal
from pitotbench.browser.workers import Workers
from pitotbench.records import BadInputError

_LOOPBACK = "127.0.0.1"
_TRIES = 50  # ports
_LEFT = 1800.0  # s after which a page that nobody looks at ends
_LOOK = 5.0  # s between looks whether somebody does
_MOST_JSON = 4 << 20  # bytes of a choice
_BAD = 400
_TYPES = {"page.js": "text/javascript", "page.css": "text/css"}


class OwnFile(RequestHandler):
    """Gives the script and the style of the page."""

    def get(self, name: str) -> None:
        self.set_header("Content-Type", f"{_TYPES[name]}; charset=utf-8")
        self.finish(own_file(name))


class Act(RequestHandler):
    """Takes a choice that was made on the page."""

    def initialize(self, desk: Desk) -> None:
        self._desk = desk

    def post(self) -> None:
        if len(self.request.body) > _MOST_JSON or "json" not in self.request.headers.get(
            "Content-Type", ""
        ):
            raise_bad(self, "no choice of this page")
            return
        try:
            act(self._desk, json.loads(self.request.body))
        except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
            raise_bad(self, f"no choice of this page: {type(error).__name__}")


def raise_bad(handler: RequestHandler, words: str) -> None:
    """Answer a request that is none of the page."""
    handler.set_status(_BAD)
    handler.set_header("Content-Type", "text/plain; charset=utf-8")
    handler.finish(words)


def act(desk: Desk, choice: dict[str, Any]) -> None:
    """Make a choice of the page: choose logs, change flags, read with a mapping, reduce legs."""
    what = choice["what"]
    if what == "arrived":
        desk.add_drop(str(choice["drop"]))
    elif what == "choose":
        desk.choose([int(place) for place in choice["places"]])
    elif what == "flags":
        stated = {name: str(choice["flags"][name]).strip() for name in FLAGS}
        spans = [span.strip() for span in str(choice["without"]).split(",")]
        desk.change(**stated, without=tuple(filter(None, spans)))
    elif what == "unit" and choice["unit"] in UNITS:
        desk.show_in(choice["unit"])
    elif what == "brush":
        desk.leave_out = bool(choice["leave_out"])
        desk.tell()
    elif what == "map":
        desk.read_with([(str(a), str(b), str(c)) for a, b, c in choice["rows"]])
    elif what == "legs":
        desk.reduce(
            [[str(cell) for cell in row] for row in choice["rows"]], bool(choice["heading"])
        )
    else:
        raise ValueError(what)


class Take(RequestHandler):
    """Gives a file to take away."""

    def initialize(self, desk: Desk) -> None:
        self._desk = desk

    async def get(self, kind: str) -> None:
        found = await self._desk.take(kind)
        if isinstance(found, Refusal):
            raise_bad(self, found.words)
            return
        plain = "".join(
            c if c.isascii() and (c.isalnum() or c in "-_.") else "-" for c in found.name
        )
        self.set_header("Content-Type", "application/octet-stream")
        self.set_header("Content-Disposition", f'attachment; filename="{plain}"')
        self.finish(found.text)


class PageServer:
    """A running page. Close it at the end."""

    def __init__(
        self,
        port: int,
        workers: Workers | None = None,
        left: float = _LEFT,
        most: int = MOST_BYTES,
    ) -> None:
        sockets, self.port = free_port(port)
        self.access = Access(self.port, token_urlsafe())
        self.desk = Desk(Store(), workers or Workers())
        self._left, self._seen = left, time.monotonic()
        desk = self.desk
        application = Application(FunctionHandler(lambda document: open_document(desk, document)))
        self.guarded = Guarded(
            {"/": application},
            self.access,
            secret_key=token_urlsafe().encode(),
            sign_sessions=True,
            extra_patterns=[
                (r"/own/(page\.js|page\.css)", OwnFile),
                (r"/upload", Upload, {"store": desk.store, "most": most}),
                (r"/act", Act, {"desk": desk}),
                (r"/take/([a-z]+)", Take, {"desk": desk}),
            ],
        )
        http = HTTPServer(self.guarded)
        http.add_sockets(sockets)
        self._server = BaseServer(IOLoop.current(), self.guarded, http)
        self._server.start()

    def watched(self) -> bool:
        """Return whether a tab is open, or was a short time ago."""
        if any(session.connection_count for session in self._server.get_sessions("/")):
            self._seen = time.monotonic()
        return time.monotonic() - self._seen < self._left

    async def until_left(self) -> None:
        """Wait until nobody has looked at the page for half an hour."""
        while self.watched():
            await asyncio.sleep(min(_LOOK, self._left))

    def close(self) -> None:
        """End the server and its children, and delete the files."""
        self._server.stop(wait=False)
        self.desk.close()


def free_port(port: int) -> tuple[list[socket], int]:
    """Return sockets on the first free port from `port` on, and its number.

    Raises BadInputError where none of the next 50 is free.
    """
    for number in range(port, port + _TRIES):
        try:
            sockets = bind_sockets(number, _LOOPBACK)
        except OSError as error:
            if error.errno != EADDRINUSE:
                raise
            continue
        return sockets, sockets[0].getsockname()[1]
    raise BadInputError(f"the ports {port} to {port + _TRIES - 1} are taken: give another --port")


def run_page(
    places: Sequence[Path], port: int, show: Callable[[str], None], say: Callable[[str], None]
) -> None:
    """Serve the page with some files until it is left. `show` opens an address; `say` prints a line.

    Raises BadInputError where no port is free, KeyboardInterrupt where it is stopped.
    """

    async def serve() -> None:
        server = PageServer(port)
        try:
            if port not in (0, server.port):
                say(f"port {port} is taken: port {server.port} is used")
            say(f"open this page: {server.access.address}")
            say(
                "It is on this computer alone, and ends with Ctrl-C or half an hour after its last tab."
            )
            show(server.access.address)
            for place in places:
                names = {"": f"{place}/"} if place.is_dir() else {place.name: str(place)}
                server.desk.add(place, names)
            await server.until_left()
            say("nobody looked at the page for half an hour: it is closed")
        finally:
            server.close()

    asyncio.run(serve())
