"""A real Chromium without a window, driven over its DevTools protocol; and the page to look at."""

import asyncio
import base64
import json
import os
import re
import shutil
import subprocess
import sys
import time
import urllib.request
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

import pytest

ROOT = Path(__file__).parents[2]
NAMES = ("chromium", "chromium-browser", "google-chrome")
PATIENCE = 120.0  # s, until a wait is a failure: no measure of speed


def program() -> str:
    """The path of a browser, or skip."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip(f"no browser: install one of {', '.join(NAMES)}")
    return found


def child_environment() -> dict[str, str]:
    paths = [str(ROOT / "src"), *filter(None, [os.environ.get("PYTHONPATH")])]
    return os.environ | {"PYTHONPATH": os.pathsep.join(paths)}


def texts(nodes: Sequence[Any], *kinds: str) -> list[str]:
    """The texts of an answer's nodes of some kinds, of those inside them too."""
    own = (
        ([node["text"]] if node["kind"] in kinds else []) + texts(node["nodes"], *kinds)
        for node in nodes
    )
    return [text for found in own for text in found]


def tables(nodes: Sequence[Any]) -> list[Any]:
    """The tables of an answer."""
    return [node for node in nodes if node["kind"] == "table"]


class Served:
    """`pitotbench open` in a process of its own."""

    def __init__(self, *arguments: str | Path) -> None:
        command = [sys.executable, "-m", "pitotbench", "open", "--no-browser", "--port", "0"]
        self.process = subprocess.Popen(
            [*command, *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=child_environment(),
        )
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        found = re.search(r"http://\S+", line)
        assert found, line + self.process.stdout.read()
        self.address = found[0]

    @property
    def host(self) -> str:
        return self.address.split("/")[2]

    def close(self) -> None:
        self.process.terminate()
        self.process.wait(30)


class Browser:
    """One tab of a browser. Waits for events; collects what was requested and what went wrong."""

    def __init__(self, folder: Path, width: int = 1200, height: int = 900) -> None:
        self.folder = folder
        self._runner = asyncio.Runner()
        self._count = 0
        self._waiting: dict[int, asyncio.Future[Any]] = {}
        self.requested: list[str] = []
        self.wrong: list[str] = []
        self.process = subprocess.Popen(
            [
                program(), "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                "--no-first-run", "--disable-background-networking", "--disable-component-update",
                "--disable-sync", "--disable-extensions", "--remote-debugging-port=0",
                f"--user-data-dir={folder / 'profile'}", f"--window-size={width},{height}", "about:blank",
            ],
            stderr=subprocess.PIPE,
            text=True,
        )  # fmt: skip
        assert self.process.stderr is not None
        lines: list[str] = []
        while not (found := re.search(r"ws://([\d.:]+)/", lines[-1] if lines else "")):
            line = self.process.stderr.readline()
            assert line, "".join(lines)
            lines.append(line)
        pages = json.loads(urllib.request.urlopen(f"http://{found[1]}/json").read())
        address = next(page for page in pages if page["type"] == "page")["webSocketDebuggerUrl"]
        self._runner.run(self._connect(address))
        for domain in ("Page", "Runtime", "Network", "Log", "DOM"):
            self.call(f"{domain}.enable")
        self.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(folder))
        self.resize(width, height)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait(30)
        self._runner.close()

    async def _connect(self, address: str) -> None:
        from tornado.websocket import websocket_connect

        self._socket = await websocket_connect(address, max_message_size=1 << 28)
        self._reader = asyncio.ensure_future(self._read())

    async def _read(self) -> None:
        while (text := await self._socket.read_message()) is not None:
            message = json.loads(text)
            future = self._waiting.pop(message.get("id", -1), None)
            if future is not None and not future.done():
                future.set_result(message)
            told = message.get("params", {})
            match message.get("method"):
                case "Network.requestWillBeSent":
                    self.requested.append(told["request"]["url"])
                case "Network.webSocketCreated":
                    self.requested.append(told["url"])
                case "Runtime.exceptionThrown":
                    self.wrong.append(json.dumps(told["exceptionDetails"]))
                case "Log.entryAdded" if told["entry"]["level"] == "error":
                    self.wrong.append(told["entry"]["text"])

    async def _call(self, method: str, parameters: dict[str, Any]) -> Any:
        self._count += 1
        future: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        self._waiting[self._count] = future
        await self._socket.write_message(
            json.dumps({"id": self._count, "method": method, "params": parameters})
        )
        message = await asyncio.wait_for(future, PATIENCE)
        assert "error" not in message, message
        return message["result"]

    def call(self, method: str, **parameters: Any) -> Any:
        return self._runner.run(self._call(method, parameters))

    def run(self, script: str) -> Any:
        """The value of an expression on the page."""
        found = self.call(
            "Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def until(self, script: str, pause: float = 0.05) -> Any:
        """Wait until an expression on the page is true; return its value."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if value := self.run(script):
                return value
            self._runner.run(asyncio.sleep(pause))
        raise AssertionError(
            f"{script} did not come true; {self.wrong}; {self.run('document.body.innerText')[:2000]}"
        )

    def open(self, address: str) -> None:
        self.call("Page.navigate", url=address)
        self.until("typeof state !== 'undefined' && state !== null")

    def answered(self) -> dict[str, Any]:
        """Wait until nothing is computed, and return what the page was told."""
        self.until("state && state.status === '' && (state.answer || state.refusal) && true")
        return dict(self.run("state"))

    def resize(self, width: int, height: int) -> None:
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width, height=height, deviceScaleFactor=1, mobile=width < 600,
        )  # fmt: skip

    def choose_files(self, paths: Sequence[Path]) -> None:
        """Give files to the button of the page."""
        root = self.call("DOM.getDocument")["root"]["nodeId"]
        node = self.call("DOM.querySelector", nodeId=root, selector="#files")["nodeId"]
        self.call("DOM.setFileInputFiles", nodeId=node, files=[str(path) for path in paths])

    def drop(self, paths: Sequence[Path]) -> None:
        """Drag files from outside onto the page."""
        held = {"items": [], "files": [str(path) for path in paths], "dragOperationsMask": 1}
        for kind in ("dragEnter", "dragOver", "drop"):
            self.call("Input.dispatchDragEvent", type=kind, x=300, y=120, data=held)

    def box(self, name: str) -> dict[str, float]:
        """The place on the screen of the frame of a picture."""
        return dict(
            self.run(
                f"""(() => {{ const find = (view) => {{
                      if (view.model.name === {name!r}) return view;
                      for (const each of view.child_views || []) {{
                        const found = find(each); if (found) return found; }} }};
                    const view = [...Bokeh.index.roots].map(find).find(Boolean);
                    view.el.scrollIntoView({{block: "center"}});
                    const host = view.el.getBoundingClientRect(), frame = view.frame.bbox;
                    return {{x: host.x + frame.left, y: host.y + frame.top,
                            width: frame.width, height: frame.height,
                            start: view.model.x_range.start, end: view.model.x_range.end}}; }})()"""
            )
        )

    def drag(self, begin: tuple[float, float], end: tuple[float, float], steps: int = 6) -> None:
        """Drag the pointer."""
        mouse = {"button": "left", "buttons": 1, "clickCount": 1}
        x, y = begin
        self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
        self.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, **mouse)
        for step in range(1, steps + 1):
            share = step / steps
            self.call(
                "Input.dispatchMouseEvent", type="mouseMoved", **mouse,
                x=x + share * (end[0] - x), y=y + share * (end[1] - y),
            )  # fmt: skip
        self.call("Input.dispatchMouseEvent", type="mouseReleased", x=end[0], y=end[1], **mouse)

    def brush(self, low: float, high: float) -> None:
        """Drag over minutes of the picture over time."""
        box = self.box("time")
        scale = box["width"] / (box["end"] - box["start"])
        x = [box["x"] + (minute - box["start"]) * scale for minute in (low, high)]
        y = box["y"] + 0.5 * box["height"]
        self.drag((x[0], y), (x[1], y))

    def picture(self, path: Path, whole: bool = True) -> None:
        """Write what is seen as a PNG."""
        found = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(found["data"]))
