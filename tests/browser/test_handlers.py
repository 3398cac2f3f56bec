"""The server of the page without a browser: who is let in, what is taken, and what a child may use."""

import asyncio
import os
import signal
import stat
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.parse import unquote, urlsplit

import numpy as np
import pytest

pytest.importorskip("bokeh", reason="the page needs Bokeh: pip install 'pitotbench[open]'")

from tests.browser import questions
from tornado.httpclient import AsyncHTTPClient, HTTPResponse
from tornado.websocket import websocket_connect

from pitotbench.browser import server as page_server
from pitotbench.browser import words
from pitotbench.browser.desk import Desk
from pitotbench.browser.page import picture_data
from pitotbench.browser.server import PageServer, act
from pitotbench.browser.uploads import Store, ending_of, shown_name
from pitotbench.browser.words import in_fields, state_of
from pitotbench.browser.work import (
    EXAMPLE,
    SETTINGS,
    Found,
    Request,
    draft,
    find_flights,
    fly_example,
    reduce_legs,
)
from pitotbench.browser.workers import Limits, Workers
from pitotbench.cli import open as open_command
from pitotbench.cli.app import command_line
from pitotbench.logbook import bundle
from pitotbench.records import BadInputError
from pitotbench.records.calibration_request import NamedFile
from pitotbench.records.log import FlightSummary
from pitotbench.records.over_dates import DatedChange, OverDates
from pitotbench.show.reader_units import BENCH
from pitotbench.units import KNOT

PAGE = Path(page_server.__file__).parent / "page"


class Recorder:
    """Children that answer nothing, and tell what was asked and what was given up."""

    def __init__(self) -> None:
        self.asked: list[tuple[Any, ...]] = []
        self.over: list[tuple[Any, ...]] = []
        self.answer: asyncio.Event | None = None

    async def ask(self, *question: Any) -> AsyncIterator[Any]:
        self.asked.append(question)
        self.answer = self.answer or asyncio.Event()
        await self.answer.wait()
        self.over.append(question)
        yield "refusal", "answered"

    def close(self) -> None:
        """Nothing to end."""


Visit = Callable[..., Awaitable[HTTPResponse]]


def with_server(visit: Callable[[PageServer, Visit], Awaitable[None]], most: int = 1000) -> None:
    """Run a visit to a server without children. `visit` gets a function that asks it."""

    async def run() -> None:
        server = PageServer(0, Recorder(), most=most)  # type: ignore[arg-type]
        client = AsyncHTTPClient(force_instance=True)

        async def fetch(path: str, cookie: bool = True, **settings: Any) -> HTTPResponse:
            headers = dict(settings.pop("headers", {}))
            if cookie:
                headers["Cookie"] = f"{server.access.cookie}={server.access.secret}"
            return await client.fetch(
                f"http://127.0.0.1:{server.port}{path}",
                headers=headers, raise_error=False, follow_redirects=False, **settings,
            )  # fmt: skip

        try:
            await visit(server, fetch)
        finally:
            client.close()
            server.close()

    asyncio.run(run())


def test_the_secret_moves_from_the_address_into_a_cookie() -> None:
    async def visit(server: PageServer, fetch: Visit) -> None:
        found = await fetch(f"/?token={server.access.token}", cookie=False)
        assert (found.code, found.headers["Location"]) == (302, "/")
        cookie = found.headers["Set-Cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=Strict" in cookie
        page = await fetch("/")
        assert page.code == 200
        assert server.access.token.encode() not in page.body
        assert server.access.secret.encode() not in page.body
        assert server.access.token not in cookie
        policy = page.headers["Content-Security-Policy"]
        assert policy.startswith("default-src 'none'; script-src 'self' 'nonce-")
        assert "unsafe-eval" not in policy
        assert page.headers["Referrer-Policy"] == "no-referrer"

    with_server(visit)


@pytest.mark.parametrize("path", ["/", "/static/js/bokeh.min.js", "/own/page.js", "/take/json"])
def test_who_does_not_hold_the_secret_sees_nothing(path: str) -> None:
    async def visit(server: PageServer, fetch: Visit) -> None:
        refused = [
            await fetch(path, cookie=False),
            await fetch(f"{path}?token=wrong", cookie=False),
            await fetch(path, cookie=False, headers={"Cookie": f"{server.access.cookie}=wrong"}),
            await fetch(path, headers={"Host": f"evil.example:{server.port}"}),
            await fetch(path, headers={"Host": "127.0.0.1:1"}),
            await fetch(path, headers={"Origin": "http://evil.example"}),
            await fetch(path, headers={"Origin": "null"}),
        ]
        assert [each.code for each in refused] == [403] * len(refused)
        own = f"http://localhost:{server.port}"
        assert (await fetch(path, headers={"Origin": own})).code != 403

    with_server(visit)


def test_the_browser_is_started_with_a_private_file_and_not_with_the_secret() -> None:
    """What a process was started with is seen by all who use the computer."""

    async def visit(server: PageServer, _fetch: Visit) -> None:
        address = server.entrance()
        assert address.startswith("file://")
        assert server.access.token not in address
        file = Path(unquote(urlsplit(address).path))
        assert server.access.address in file.read_text(encoding="utf-8")
        assert any(part.stat().st_mode & 0o077 == 0 for part in file.parents[:2])

    with_server(visit)


def test_the_names_in_a_zip_bring_no_control_codes_to_a_command(tmp_path: Path) -> None:
    packed = tmp_path / "card.zip"
    with zipfile.ZipFile(packed, "w") as file:
        file.writestr("a\x03\nrm \u202e.csv", "time_s,x\n0,1\n")
    told: dict[str, Any] = {}
    find_flights(told.__setitem__, packed, {packed.name: "card.zip"}, tmp_path / "unpacked")
    names = [each.log.name for each in told["found"]]
    assert names
    assert all(name.isprintable() for name in names)


def test_the_secret_in_the_address_does_not_help_another_host() -> None:
    async def visit(server: PageServer, fetch: Visit) -> None:
        address = f"/?token={server.access.token}"
        for headers in ({"Host": "evil.example"}, {"Origin": "http://evil.example"}):
            assert (await fetch(address, cookie=False, headers=headers)).code == 403

    with_server(visit)


@pytest.mark.parametrize("path", ["/autoload.js?bokeh-autoload-element=a", "/metadata"])
def test_what_bokeh_offers_to_other_pages_is_closed(path: str) -> None:
    async def visit(_server: PageServer, fetch: Visit) -> None:
        assert (await fetch(path)).code == 404

    with_server(visit)


def test_the_websocket_has_the_same_gate() -> None:
    async def visit(server: PageServer, _fetch: Visit) -> None:
        with pytest.raises(Exception, match="403"):
            await websocket_connect(f"ws://127.0.0.1:{server.port}/ws")

    with_server(visit)


def upload(name: str, body: bytes = b"a,b\n1,2\n", **headers: str) -> dict[str, Any]:
    return {"method": "POST", "body": body, "headers": {"X-Name": name, "X-Drop": "d", **headers}}


def test_an_uploaded_file_gets_our_name_and_goes_at_the_end() -> None:
    kept: list[Path] = []

    async def visit(server: PageServer, fetch: Visit) -> None:
        name = "..%2F..%2Fetc%2F%3Cb%3Eflight.csv"
        assert (await fetch("/upload", **upload(name))).code == 200
        ((path, shown),) = server.desk.store.names("d").items()
        assert path.read_bytes() == b"a,b\n1,2\n"
        assert path.name.startswith("log")
        assert path.name.endswith(".csv")
        assert shown == "etc/<b>flight.csv"
        assert stat.S_IMODE(path.parents[1].stat().st_mode) == 0o700
        kept.append(path)

    with_server(visit)
    assert not kept[0].parents[1].exists()


@pytest.mark.parametrize(
    ("request_", "code"),
    [
        (upload("flight.csv", bytes(1001)), 413),
        (upload("flight.exe"), 415),
        (upload("flight"), 415),
        (upload("flight.csv", **{"Origin": "http://evil.example"}), 403),
    ],
)
def test_a_file_that_is_not_taken_leaves_nothing(request_: dict[str, Any], code: int) -> None:
    async def visit(server: PageServer, fetch: Visit) -> None:
        assert (await fetch("/upload", **request_)).code == code
        assert server.desk.store.names("d") == {}

    with_server(visit)


def test_without_the_cookie_a_large_body_is_not_read() -> None:
    async def visit(server: PageServer, _fetch: Visit) -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
        head = (
            f"POST /upload HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nContent-Length: 900\r\n\r\n"
        )
        writer.write(head.encode())  # and no body
        line = await asyncio.wait_for(reader.readline(), 30)
        assert b"403" in line
        writer.close()

    with_server(visit)


def test_files_of_one_log_keep_the_endings_by_which_they_are_found() -> None:
    store = Store()
    names = ["a/differential_pressure_0.csv", "a/sensor_gps_0.csv", "b.csv", "c.ULG", "d.csv.gz"]
    paths = [store.new_path(name, "drop") for name in names]
    assert [path.name for path in paths if path][:2] == [
        "logdifferential_pressure_0.csv",
        "logsensor_gps_0.csv",
    ]
    assert [ending_of(name) for name in names[2:]] == [".csv", ".ulg", ".csv.gz"]
    assert len({path.parent for path in paths if path}) == 1
    assert shown_name("a\x1b[2J\u202eb.csv") == "a[2Jb.csv"
    store.close()


def zipped(path: Path, members: dict[str, bytes], link: bool = False) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in members.items():
            entry = zipfile.ZipInfo(name)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (stat.S_IFLNK | 0o777 if link else 0o600) << 16
            file.writestr(entry, data)
    return path


@pytest.mark.parametrize(
    ("members", "link", "words"),
    [
        ({"../flight.csv": b"a"}, False, "leads out"),
        ({"a/../../flight.csv": b"a"}, False, "leads out"),
        ({"/etc/flight.csv": b"a"}, False, "leads out"),
        ({"..\\flight.csv": b"a"}, False, "leads out"),
        ({"c:\\flight.csv": b"a"}, False, "leads out"),
        ({"flight.csv": b"/etc/passwd"}, True, "link"),
        ({f"{i}.csv": b"" for i in range(10_001)}, False, "10,001 files"),
    ],
    ids=["up", "up inside", "root", "backslash", "drive", "link", "many"],
)
def test_a_zip_that_leads_out_or_is_a_bomb_is_refused(
    tmp_path: Path, members: dict[str, bytes], link: bool, words: str
) -> None:
    path = zipped(tmp_path / "card.zip", members, link)
    with pytest.raises(BadInputError, match=words):
        bundle.unpack(path, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_zip_that_unpacks_to_too_much_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bundle, "_MOST_BYTES", 1 << 20)
    path = zipped(tmp_path / "card.zip", {"flight.csv": bytes((1 << 20) + 1)})
    assert path.stat().st_size < 1 << 14
    with pytest.raises(BadInputError, match="unpacks to 1 MB"):
        bundle.unpack(path, tmp_path / "out")


def test_a_member_of_a_zip_is_no_larger_than_a_packed_log(tmp_path: Path) -> None:
    path = zipped(tmp_path / "card.zip", {"flight.csv": bytes(1 << 20)})
    data, size = path.read_bytes(), (1 << 20).to_bytes(4, "little")
    path.write_bytes(data.replace(size, (500 << 20).to_bytes(4, "little")))  # as it states
    with pytest.raises(BadInputError, match=r"'flight\.csv' unpacks to 500 MB, where 400"):
        bundle.unpack(path, tmp_path / "out")


def found(name: str, refusal: str = "") -> Found:
    return Found(NamedFile(Path(f"/nowhere/{name}"), name), FlightSummary(name, refusal))


def test_a_newer_choice_gives_an_older_question_up() -> None:
    async def run() -> None:
        workers = Recorder()
        desk = Desk(Store(), workers)  # type: ignore[arg-type]
        desk.found = [found("a.csv")]
        desk.choose([0])
        await asyncio.sleep(0.3)  # it is asked
        for minute in range(50):
            desk.brush(f"{minute}:00", f"{minute + 5}:00")
        await asyncio.sleep(0.3)
        assert workers.answer is not None
        workers.answer.set()
        await asyncio.sleep(0.1)
        # The first one was asked and given up, those between never asked, the last one answered.
        assert [each[1].begin for each in workers.asked] == ["", "49:00"]
        assert [each[1].begin for each in workers.over] == ["49:00"]
        assert desk.status == ""
        desk.leave_out = True
        desk.brush("50:00", "51:00")
        await asyncio.sleep(0.3)
        assert workers.asked[-1][1].without == ("50:00-51:00",)
        desk.close()

    asyncio.run(run())


class Prepared(Recorder):
    """Children that tell of each drop what is prepared; of the first one late, where that is asked."""

    def __init__(self, late: bool, *drops: Any) -> None:
        super().__init__()
        self.late, self.drops = late, iter(drops)

    async def ask(self, *question: Any) -> AsyncIterator[Any]:
        if question[0] == find_flights:
            reply, late, self.late = next(self.drops), self.late, False
            await asyncio.sleep(0.1 * late)
            yield reply
        elif question[0] == draft:
            yield "draft", DRAFT
        else:
            yield "answer", f"of {question[1].logs[0].name}"


DRAFT = [("theirs", ("ours", "kt"), 1.0, "", "1, 2")]
STRANGE = FlightSummary("b.csv", "no known names", strange=True)
LAST = {  # what is told of the last drop, and what the page then says
    "a log": (("found", (found("b.csv"),)), ("", "of b.csv", [])),
    "refused": (("found", (found("b.csv", "empty"),)), ("b.csv: not read: empty", None, [])),
    "not opened": (("refusal", "a bomb"), ("b.csv: not read: a bomb", None, [])),
    "unknown names": (
        ("found", (replace(found("b.csv"), flight=STRANGE),)),
        ("b.csv: not read: no known names", None, DRAFT),
    ),
}


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize(("reply", "said"), LAST.values(), ids=LAST)
def test_the_page_shows_what_was_dropped_last(reply: Any, said: Any, late: bool) -> None:
    """Not an answer of before beside a file that it is not of, nor that of a file that was read
    late.
    """

    async def run() -> None:
        first = ("found", (found("a.csv"),))
        desk = Desk(Store(), Prepared(late, first, reply))  # type: ignore[arg-type]
        for name in ("a.csv", "b.csv"):
            path = desk.store.new_path(name, name)
            assert path is not None
            path.touch()
            desk.add_drop(name)
            await asyncio.sleep(0.0 if late else 0.1)
        await asyncio.sleep(0.2)
        assert (desk.refusal, desk.answer, desk.draft) == said
        desk.close()

    asyncio.run(run())


def test_of_one_drop_a_log_that_is_read_is_shown() -> None:
    async def run() -> None:
        drops = ("found", (found("a.csv"),)), ("refusal", "a bomb")
        desk = Desk(Store(), Prepared(False, *drops))  # type: ignore[arg-type]
        for name in ("a.zip", "b.zip"):
            path = desk.store.new_path(name, "one")
            assert path is not None
            path.touch()
        desk.add_drop("one")
        await asyncio.sleep(0.2)
        assert (desk.refusal, desk.answer) == ("", "of a.csv")
        desk.close()

    asyncio.run(run())


def test_a_file_that_is_dropped_twice_is_listed_once(tmp_path) -> None:
    first, copy, other = (tmp_path / name for name in ("a.csv", "copy of a.csv", "b.csv"))
    for path, text in ((first, "1"), (copy, "1"), (other, "2")):
        path.write_text(text, encoding="utf-8")

    async def run() -> None:
        replies = [
            ("found", (replace(found(path.name), log=NamedFile(path, path.name)),))
            for path in (first, other, copy)
        ]
        desk = Desk(Store(), Prepared(False, *replies))  # type: ignore[arg-type]
        for path in (first, other, copy):
            desk.add(path, {path.name: path.name})
            await asyncio.sleep(0.15)
        assert [each.log.name for each in desk.found] == ["a.csv", "b.csv"]
        assert desk.chosen == (0,)
        desk.close()

    asyncio.run(run())


def test_a_flight_is_removed_and_the_choice_of_others_stays() -> None:
    async def run() -> None:
        desk = Desk(Store(), Recorder())  # type: ignore[arg-type]
        desk.found = [found("a.csv"), found("b.csv"), found("c.csv")]
        desk.choose([1])
        act(desk, {"what": "remove", "place": 0})
        assert [each.log.name for each in desk.found] == ["b.csv", "c.csv"]
        assert desk.chosen == (0,)
        act(desk, {"what": "remove", "place": 0})
        assert (desk.chosen, desk.request) == ((), None)
        with pytest.raises(LookupError):
            act(desk, {"what": "remove", "place": 5})
        desk.close()

    asyncio.run(run())


def test_the_course_over_dates_is_told_and_drawn() -> None:
    async def visit(server: PageServer, _: Visit) -> None:
        desk = server.desk
        assert state_of(desk)["course"] is None
        days = tuple(datetime(2026, 5, day, tzinfo=UTC) for day in (1, 11, 21))
        value = np.array([[0.0, 1.0, 2.0], [0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]) * KNOT
        change = DatedChange(2, 80.0 * KNOT, 3.0 * KNOT, 0.4 * KNOT, 0.001)
        speeds = np.array([80.0, 100.0, 120.0]) * KNOT
        desk.course = OverDates(("a", "b", "c"), days, speeds, value, 0.1 * value, change)
        told = state_of(desk)["course"]
        assert "between 2026-05-11 and 2026-05-21 (from c on)" in told["said"][0]["text"]
        assert told["speeds"] == ["80 KIAS", "100 KIAS", "120 KIAS"]
        assert len(told["table"][0]["rows"]) == 3
        data = picture_data(desk)
        assert data["fast"][1] == pytest.approx([2.0, 2.0, 5.0])
        assert data["fast"][3] - data["fast"][1] == pytest.approx([0.2, 0.2, 0.5])
        assert data["changed"][0] == np.datetime64("2026-05-16")
        desk.choose(())
        assert state_of(desk)["course"] is None

    with_server(visit)


def test_a_refusal_speaks_of_fields_not_of_flags() -> None:
    said = "state the day's: --temperature-c 18±2@ground, or take a part (--from, --to); --odd"
    assert in_fields(said) == (
        "state the day's: “temperature of the day” = 18±2@ground, or take a part (“from”, “to”); --odd"
    )
    assert (
        in_fields("(old 1; --params gives the offset)") == "(old 1; “parameters” gives the offset)"
    )
    assert in_fields("add --accuracy temperature_k=1") == "add “accuracies” = temperature_k=1"
    inside = {"kind": "doubt", "text": said, "nodes": []}
    (part,) = words._said([{"kind": "heading", "text": "Doubts", "nodes": [inside]}])
    assert part["nodes"][0] == inside | {"text": in_fields(said)}
    missing = "missing column. A log with other names needs a mapping file: `pitotbench map` drafts"
    assert in_fields(missing).endswith("with other names is read by the draft below: correct it")


def test_the_airspeeds_of_the_list_are_those_of_the_answer() -> None:
    """Of the others they are the log's."""
    answered, other = (replace(found(name).flight, airspeeds=(0.0, 110.0)) for name in "ab")
    curve = SimpleNamespace(indicated_airspeed=np.array([58.0, 80.0, 116.0]))
    desk: Any = SimpleNamespace(
        found=[SimpleNamespace(flight=answered), SimpleNamespace(flight=other)],
        chosen=(0,),
        answer=SimpleNamespace(result=SimpleNamespace(curve=curve)),
    )
    assert [each.airspeeds for each in words._flights(desk)] == [(58.0, 116.0), (0.0, 110.0)]


def test_the_example_is_a_flight_that_is_read(tmp_path: Path) -> None:
    told: dict[str, Any] = {}
    place = tmp_path / "new" / EXAMPLE
    fly_example(told.__setitem__, place, {EXAMPLE: EXAMPLE}, tmp_path)
    (flight,) = told["found"]
    assert flight.log.name == EXAMPLE
    assert not flight.flight.refusal


def test_the_desk_outlives_the_tab() -> None:
    """A tab that comes back asks for the state: it holds the choices, as texts alone."""

    async def run() -> None:
        desk = Desk(Store(), Recorder())  # type: ignore[arg-type]
        desk.found = [found("<img src=x>.csv"), found("b.csv", "is empty")]
        desk.choose([0])
        flags = dict.fromkeys(SETTINGS, "") | {"begin": "1:00", "model": "quadratic"}
        act(desk, {"what": "flags", "flags": flags, "without": "3:00-4:00, 5:00-6:00"})
        act(desk, {"what": "show", "unit": "kmh", "leave_out": True})
        state = state_of(desk)
        assert (state["flags"], state["unit"], state["leave_out"]) == (flags, "kmh", True)
        assert state["without"] == ["3:00-4:00", "5:00-6:00"]
        assert state["flights"]["rows"][0][0] == "<img src=x>.csv"
        assert state["command"] == (
            "pitotbench calibrate '<img src=x>.csv' --from 1:00 "
            "--without 3:00-4:00 --without 5:00-6:00 --model quadratic --units km/h,ft,degc,inhg"
        )
        act(desk, {"what": "choose", "places": [1]})
        assert state_of(desk)["refusal"] == "b.csv: not read: is empty"
        desk.close()

    asyncio.run(run())


@pytest.mark.parametrize(
    "choice",
    [{}, {"what": "rm"}, {"what": "choose"}, {"what": "flags", "flags": {}, "without": ""},
     {"what": "show", "unit": "furlong", "leave_out": False}, {"what": "choose", "places": ["x"]}, []],
)  # fmt: skip
def test_what_is_no_choice_of_the_page_is_refused(choice: Any) -> None:
    async def visit(_server: PageServer, fetch: Visit) -> None:
        import json

        answer = await fetch("/act", method="POST", body=json.dumps(choice))
        assert answer.code == 400

    with_server(visit)


def test_a_choice_nested_without_end_is_refused() -> None:
    async def visit(_server: PageServer, fetch: Visit) -> None:
        answer = await fetch("/act", method="POST", body="[" * 200_000)
        assert answer.code == 400

    with_server(visit)


@pytest.mark.parametrize("length", ["abc", "9" * 5000, "99999999999"])
def test_a_file_without_a_length_that_is_taken_is_refused(length: str) -> None:
    async def visit(server: PageServer, _fetch: Visit) -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
        head = (
            f"POST /upload HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
            f"Cookie: {server.access.cookie}={server.access.secret}\r\n"
            f"X-Name: a.csv\r\nContent-Length: {length}\r\n\r\n"
        )
        writer.write(head.encode())
        line = await asyncio.wait_for(reader.readline(), 30)
        assert b"413" in line
        writer.close()

    with_server(visit)


def test_the_script_of_the_page_puts_texts_in_as_text() -> None:
    script = (PAGE / "page.js").read_text(encoding="utf-8")
    assert "textContent" in script
    for way in (
        "innerHTML",
        "outerHTML",
        "insertAdjacentHTML",
        "document.write",
        "eval(",
        "Function(",
    ):
        assert way not in script
    page = (PAGE / "page.html").read_text(encoding="utf-8")
    assert "http" not in page  # nothing from another host
    assert "onclick" not in page


async def told(workers: Workers, *question: Any) -> list[Any]:
    return [reply async for reply in workers.ask(*question)]


def test_a_child_that_exceeds_its_limits_ends_and_another_answers() -> None:
    pytest.importorskip("resource", reason="this system has no limits for processes")

    async def run() -> None:
        workers = Workers(1, Limits(memory=2 << 30, seconds=1))
        try:
            (late,) = await told(workers, questions.spin)
            assert late[0] == "refusal"
            assert late[1].startswith("no answer within 1 s")
            assert await told(workers, questions.echo, "again") == [("text", "again")]
            (large,) = await told(workers, questions.grow)
            assert large[0] == "refusal"
            assert "memory" in large[1]
            assert await told(workers, questions.echo, "again") == [("text", "again")]
        finally:
            workers.close()

    asyncio.run(run())


LIMITED = """
import asyncio, resource
resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
from tests.browser import questions
from pitotbench.browser.workers import Workers

async def run():
    workers = Workers(1)
    try:
        print([reply async for reply in workers.ask(questions.echo, "heard")])
    finally:
        workers.close()

if __name__ == "__main__":
    asyncio.run(run())
"""


def test_a_child_answers_where_the_system_allows_less_than_its_limit(tmp_path: Path) -> None:
    pytest.importorskip("resource", reason="this system has no limits for processes")
    script = tmp_path / "limited.py"
    script.write_text(LIMITED, encoding="utf-8")
    root = Path(__file__).parents[2]
    path = os.pathsep.join([str(root), str(root / "src")])
    told = subprocess.run(
        [sys.executable, str(script)],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert told == "[('text', 'heard')]\n"


def test_a_canceled_question_ends_its_child() -> None:
    async def run() -> None:
        workers = Workers(1)
        try:
            assert await told(workers, questions.echo, "warm") == [("text", "warm")]
            (child,) = workers._children
            task = asyncio.ensure_future(told(workers, questions.spin))
            await asyncio.sleep(0.2)
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task
            assert child._process.exitcode is not None
            assert await told(workers, questions.echo, "next") == [("text", "next")]
        finally:
            workers.close()

    asyncio.run(run())


def test_a_taken_port_is_passed_over() -> None:
    (first,), port = page_server.free_port(0)
    (second,), next_port = page_server.free_port(port)
    assert first.getsockname()[0] == second.getsockname()[0] == "127.0.0.1"
    assert next_port > port
    first.close()
    second.close()


@pytest.mark.parametrize(
    ("looks", "end"),
    [
        ((), 1800.0),
        (((0.0, 600.0),), 2400.0),  # the last tab is closed after ten minutes
        (((0.0, 600.0), (2350.0, 2351.0)), 4150.0),  # one comes back in the last minute
    ],
)
def test_the_page_ends_half_an_hour_after_its_last_tab(
    looks: Sequence[tuple[float, float]], end: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a clock that is handed in: its pauses are over at once."""
    now = [0.0]

    async def sleep(seconds: float) -> None:
        now[0] += seconds

    def is_seen() -> bool:
        return any(begin <= now[0] <= last for begin, last in looks)

    async def run() -> None:
        server = PageServer(0, Recorder())  # type: ignore[arg-type]
        monkeypatch.setattr(server, "is_seen", is_seen)
        await server.until_left(lambda: now[0], sleep)
        server.close()
        assert now[0] == end

    asyncio.run(run())


def test_without_bokeh_the_command_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(open_command, "find_spec", lambda name: None)
    with pytest.raises(BadInputError, match=r"pip install 'pitotbench\[open\]'"):
        open_command.run(command_line().parse_args(["open"]))


def test_a_request_is_the_command_that_gives_the_same() -> None:
    log, mapping = (
        NamedFile(Path("/tmp/1.csv"), "my log.csv"),
        NamedFile(Path("/tmp/m.toml"), "m.toml"),
    )
    book = NamedFile(Path("/tmp/2.csv"), "poh.csv")
    asked = Request(
        mapping,
        "1:00",
        "2:00",
        handbook=book,
        logs=(log,),
        options=(("model", "auto"), ("accuracies", "none")),
        temperature_c="18±2@ground",
        parameters="px4",
        airspeed_sensor="2",
    )
    assert asked.command(BENCH) == (
        "pitotbench calibrate 'my log.csv' --mapping m.toml --from 1:00 --to 2:00 "
        "--temperature-c '18±2@ground' --params px4 --handbook poh.csv --airspeed-sensor 2 --model auto "
        "--accuracy none"
    )
    assert asked.file_name("-card-kt.csv") == "my log-from-1m00-to-2m00-card-kt.csv"


LEFT = """
from pitotbench.browser.uploads import Store
store = Store()
store.write("flight.csv", "a,b")
print(store.known[0].path, flush=True)
input()
"""


def test_what_a_killed_page_left_goes_when_the_next_one_starts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    served = Store()
    kept = served.write("served.csv", "a,b").path
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", LEFT], env=environment, **pipes) as process:
        assert process.stdout is not None
        left = Path(process.stdout.readline().decode().strip())
        Store().close()
        assert left.is_file()  # it runs
        process.kill()
    assert left.is_file()
    Store().close()
    assert kept.is_file()
    assert [*tmp_path.iterdir()] == [kept.parents[1]]
    served.close()


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="this system has no such signal")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_files_are_deleted_when_the_page_is_ended_by_a_signal(name: str, tmp_path: Path) -> None:
    """A terminal that is closed, or a limit of time, ends it as Ctrl-C does."""
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    command = [sys.executable, "-m", "pitotbench", "open", "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout is not None
        process.stdout.readline()
        assert list(tmp_path.glob("pitotbench-*"))
        process.send_signal(getattr(signal, name))
        process.wait(120)
    assert not list(tmp_path.glob("pitotbench-*"))


NAMES = "indicated_airspeed_kt,pressure_altitude_ft,air_temperature_degc,ground_speed_kt,track_deg"
GROUND = "ground_speed_kt,track_deg"
NO_LEGS = {
    "blanks": (NAMES, "80,3000,12,93,0\n80 3000 12 93 0\n80,3000,12,93,0", "row 2 has 1 columns"),
    "semicolons": (NAMES, "80,3000,12;5,93,0", "row 1: '12;5' is not a number"),
    "commas": (NAMES, "80,,3000,12,93,0", "row 1 has 6 columns"),
    "units": (NAMES, "80 kt,3 km,12 C,93 kt,0 W\n80,3000,12,93,0", "row 1: '80 kt' is not"),
    "quotes": (f'"{NAMES.replace(",", " ")}"', '"80  3000  12  93  0"', "missing columns"),
    "a mark": (f'{NAMES}\n"', "80,3000,12,93,0", "no row below"),
    "no legs": (NAMES, "", "no row below"),
    "a word": (GROUND, "93 at,0", "row 1: '93 at' is not a number"),
    "a blank": (GROUND, "93,", "row 1: a number is missing"),
    "one number": (GROUND, "93\n93,0", "row 1 has 1 columns"),
    "three numbers": (f"{GROUND},more", "93,0,1", "got 1"),
    "speeds alone": ("ground_speed_kt", "93", "missing column track_deg"),
}


@pytest.mark.parametrize(("names", "row", "words"), NO_LEGS.values(), ids=NO_LEGS)
def test_typed_legs_that_are_none_are_refused_in_one_sentence(
    names: str, row: str, words: str, tmp_path: Path
) -> None:
    card = tmp_path / "legs.csv"
    card.write_text(f"{names}\n{row}\n", encoding="utf-8")
    with pytest.raises(BadInputError, match=words):
        reduce_legs(lambda *_: None, card, "")


def test_the_command_of_typed_legs_states_the_accuracy_of_the_page(tmp_path):
    card, told = tmp_path / "legs.csv", dict[str, Any]()
    rows = [f"1,90,3000,10,{speed},{track}" for speed, track in ((99, 0), (92, 120), (97, 240))]
    names = "point,indicated_airspeed_kt,pressure_altitude_ft,air_temperature_degc,ground_speed_kt"
    card.write_text("\n".join([f"{names},track_deg", *rows]), encoding="utf-8")
    for accuracy, flags in (("", ""), ("temperature_k=1", " --accuracy temperature_k=1")):
        reduce_legs(told.__setitem__, card, accuracy)
        assert told["legs"]["command"] == f"pitotbench fixed-speed legs.csv{flags}"
