"""The page in a real browser: it says what the commands say, and asks no other host."""

import json
import os
from collections.abc import Iterator
from contextlib import redirect_stdout
from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("bokeh", reason="the page needs Bokeh: pip install 'pitotbench[open]'")

from tests.browser.chromium import Browser, Served, program, tables, texts

from pitotbench import Case, fly
from pitotbench.cli.app import main
from pitotbench.logbook.csv import read_csv
from pitotbench.logbook.formats import write_log
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system

LEGS = [  # KIAS, pressure altitude [ft], air temperature [°C], ground speed [kt], track [°]
    ["90", "3000", "9", "100", "0"],
    ["90", "3,000", "9", "87", "120"],
    ["90 kt", "3000 ft", "9 °C", "95", "240°"],
]
HEADINGS = (
    "indicated_airspeed_kt,pressure_altitude_ft,air_temperature_degc,ground_speed_kt,track_deg"
)


@cache
def command(*arguments: str | Path) -> Any:
    """The document that a command prints."""
    printed = StringIO()
    with redirect_stdout(printed):
        assert main([*map(str, arguments), "--json"]) == 0
    return json.loads(printed.getvalue())


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulated flight, as a file."""
    program()
    folder = tmp_path_factory.mktemp("flight")
    flight = fly(Case(maneuver="circle", turbulence="light"))
    path = folder / "flight one.csv"
    write_log(record(flight, data_system("5/1"), 1), path)
    return path


@pytest.fixture(scope="module")
def served() -> Iterator[Served]:
    program()
    page = Served()
    yield page
    page.close()


@pytest.fixture(scope="module")
def browser(served: Served, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with Browser(tmp_path_factory.mktemp("browser")) as tab:
        tab.open(served.address)
        yield tab


@pytest.fixture
def dropped(browser: Browser, log: Path) -> Browser:
    """The page with the answer for the whole simulated log."""
    if not browser.run("state.flights.rows.length"):
        browser.drop([log])
        browser.until("state.command !== ''")
    elif browser.run("state.flags.begin + state.flags.end + state.without.join()"):
        browser.run("document.getElementById('whole').click()")
        browser.until("state.flags.begin + state.flags.end + state.without.join() === ''")
    browser.answered()
    return browser


@pytest.fixture(scope="module")
def answer(log: Path) -> Any:
    """The document of the command for the whole simulated log, with card and record beside it."""
    beside = ["--card", log.with_name("card.csv"), "--record", log.with_name("record.html")]
    return command("calibrate", log, *beside)


def type_minutes(browser: Browser, begin: str, end: str) -> None:
    """Type a part of the log into the form."""
    browser.run(
        "(() => { const form = document.getElementById('flags');"
        f"form.elements.begin.value = {begin!r}; form.elements.end.value = {end!r};"
        "form.requestSubmit(); })()"
    )
    browser.until(f"state.flags.begin === {begin!r} && state.flags.end === {end!r}")


def download(browser: Browser, kind: str) -> str:
    """The text of a file to take away, by the cookie of the page."""
    return str(browser.run(f"fetch('/take/{kind}').then((reply) => reply.text())"))


def same(page: Any, other: Any) -> None:
    """The curve, the wind and the warnings of two documents agree to the last digit."""
    for name in ("curve", "wind", "parts", "samples", "disagreements", "limits", "warnings"):
        assert page[name] == other[name], name


def test_a_dropped_log_has_the_answer_of_the_command(
    dropped: Browser, log: Path, answer: Any
) -> None:
    state = dropped.answered()
    page = json.loads(download(dropped, "json"))
    same(page, answer)
    assert page["log"] == log.name
    first = answer["curve"][0]
    sentence = texts(state["answer"]["tree"], "sentence")[0]
    assert f"{first['correction_kt']:+.2f}".replace("-", "−") in sentence
    assert state["command"] == "pitotbench calibrate 'flight one.csv'"
    ends = [f"{answer['curve'][end]['indicated_airspeed_kt']:.0f}" for end in (0, -1)]
    assert state["flights"]["rows"][0][-2:] == ends
    assert dropped.run("document.querySelector('[aria-live] p').textContent") == sentence
    # Every sentence and doubt of the tree is on the page.
    shown = dropped.run("document.getElementById('answer').textContent")
    shown += dropped.run("document.getElementById('rest').textContent")
    for text in texts(state["answer"]["tree"], "sentence", "doubt", "notice"):
        assert text in shown


def test_the_curve_stands_beside_the_answer_on_the_first_screen(dropped: Browser) -> None:
    dropped.resize(1200, 900)
    dropped.run("window.scrollTo(0, 0)")
    places = [
        dropped.run(
            f"(() => {{ const box = document.getElementById('{name}').getBoundingClientRect();"
            "return [box.left, box.right, box.top, box.bottom]; })()"
        )
        for name in ("answer", "curve")
    ]
    assert places[0][1] < places[1][0]
    assert max(place[3] for place in places) < 900


def test_card_and_record_are_those_of_the_command(dropped: Browser, log: Path, answer: Any) -> None:
    card = log.with_name("card.csv")
    assert download(dropped, "card") == card.read_text(encoding="utf-8")
    assert len(read_csv(card)) >= len(tables(dropped.answered()["answer"]["tree"])[0]["rows"]) > 2
    assert download(dropped, "record") == log.with_name("record.html").read_text(encoding="utf-8")
    assert download(dropped, "json").count(answer["model"]) >= 1


def test_a_file_says_its_minutes_and_its_unit_in_its_name(dropped: Browser) -> None:
    type_minutes(dropped, "1:00", "4:00")
    dropped.answered()
    named = "fetch('/take/card').then((reply) => reply.headers.get('Content-Disposition'))"
    assert dropped.run(named) == 'attachment; filename="flight-one-from-1m00-to-4m00-card-kt.csv"'


def test_page_and_record_are_self_contained_pages(dropped: Browser, log: Path) -> None:
    for kind in ("page", "record"):
        text = download(dropped, kind)
        assert text.startswith("<!DOCTYPE html>") or text.startswith("<!doctype html>")
        assert log.name in text


def test_brushed_minutes_have_the_answer_of_from_and_to(dropped: Browser, log: Path) -> None:
    end = dropped.box("time")["end"]
    dropped.brush(0.1 * end, 0.7 * end)
    dropped.until("state.flags.begin !== ''")
    state = dropped.answered()
    begin, last = state["flags"]["begin"], state["flags"]["end"]
    assert f"--from {begin} --to {last}" in state["command"]
    same(
        json.loads(download(dropped, "json")),
        command("calibrate", log, "--from", begin, "--to", last),
    )


def test_minutes_are_left_out_as_by_without(dropped: Browser, log: Path, answer: Any) -> None:
    dropped.run("document.querySelector('[value=leave]').click()")
    dropped.until("state.leave_out")
    end = dropped.box("time")["end"]
    dropped.brush(0.4 * end, 0.55 * end)
    dropped.until("state.without.length === 1")
    state = dropped.answered()
    document = json.loads(download(dropped, "json"))
    same(document, command("calibrate", log, "--without", state["without"][0]))
    assert document["samples"] < answer["samples"]
    dropped.run("document.querySelector('[value=use]').click()")
    dropped.until("!state.leave_out")


def test_a_brush_over_all_minutes_is_the_whole_log(dropped: Browser) -> None:
    """Its answer is known, and not asked for again."""
    box = dropped.box("time")
    type_minutes(dropped, "1:00", "4:00")
    y = box["y"] + 0.5 * box["height"]
    dropped.drag((box["x"] + 1.0, y), (box["x"] + box["width"] - 1.0, y))
    dropped.until("state.flags.begin + state.flags.end === ''")
    assert "--from" not in dropped.answered()["command"]


def test_a_wrong_value_is_refused_in_the_words_of_the_command_by_its_field(
    dropped: Browser,
) -> None:
    for text, words in (("soon", "“from” = 'soon': give minutes and seconds"), ("", "")):
        dropped.run(
            f"(() => {{ const form = document.getElementById('flags'); "
            f"form.elements.begin.value = {text!r}; form.requestSubmit(); }})()"
        )
        dropped.until(f"state.flags.begin === {text!r}")
        assert dropped.answered()["refusal"].startswith(words)


def test_speeds_are_shown_in_other_units(dropped: Browser) -> None:
    knots = dropped.answered()["answer"]
    dropped.run(
        "(() => { const unit = document.getElementById('unit'); unit.value = 'kmh';"
        "unit.dispatchEvent(new Event('change')); })()"
    )
    dropped.until("state.unit === 'kmh'")
    state = dropped.answered()["answer"]
    assert "km/h" in texts(state["tree"], "sentence")[0]
    card, other_card = tables(state["tree"])[0], tables(knots["tree"])[0]
    assert card["head"][0] == "IAS [km/h]"
    for row, other in zip(card["rows"], other_card["rows"], strict=True):
        assert float(row[1]) == pytest.approx(1.852 * float(other[1]), abs=0.15)
    assert "km/h" in dropped.run(
        "Bokeh.documents[0].get_model_by_name('error').below[0].axis_label"
    )
    dropped.run(
        "(() => { const unit = document.getElementById('unit'); unit.value = 'kt';"
        "unit.dispatchEvent(new Event('change')); })()"
    )
    dropped.until("state.unit === 'kt'")


def test_every_option_of_the_command_is_on_the_page_with_its_help(dropped: Browser) -> None:
    missing = (
        "Object.keys(state.settings).filter((n) => !document.getElementById('flags').elements[n])"
    )
    assert dropped.run(missing) == []
    title = "document.getElementById('flags').elements.wind.closest('label').title"
    assert "constant, checked" in dropped.run(title)
    ask = (
        "(() => {{ const form = document.getElementById('flags'); form.elements.wind.value = '{}';"
        "form.elements.use_down.value = '{}'; form.requestSubmit(); }})()"
    )
    dropped.run(ask.format("constant", "yes"))
    dropped.until("state.flags.wind === 'constant'")
    asked = dropped.answered()
    assert (asked["refusal"], asked["answer"]["usable"]) == ("", True)
    assert asked["command"].endswith(" --no-down --wind constant")
    dropped.run(ask.format("", ""))
    dropped.until("state.flags.wind === ''")
    dropped.answered()


def test_a_reloaded_tab_finds_its_choices(dropped: Browser, served: Served) -> None:
    dropped.run(
        "(() => { const form = document.getElementById('flags'); form.elements.model.value = 'quadratic';"
        "form.requestSubmit(); })()"
    )
    dropped.until("state.flags.model === 'quadratic'")
    before = dropped.answered()
    dropped.open(f"http://{served.host}/")
    assert dropped.answered() == before
    assert dropped.run("document.getElementById('flags').elements.model.value") == "quadratic"
    assert dropped.run("location.search") == ""
    dropped.run(
        "(() => { const form = document.getElementById('flags'); form.elements.model.value = '';"
        "form.requestSubmit(); })()"
    )
    dropped.until("state.flags.model === ''")
    dropped.answered()


def test_a_tapped_sample_lights_up_in_the_flight(dropped: Browser) -> None:
    dropped.run(
        "Bokeh.documents[0].get_model_by_name('error').renderers.map((each) => each.data_source)"
        ".find((each) => each.columns().includes('minute') && each.get_length() > 1)"
        ".selected.indices = [5]"
    )
    lit = (
        "(() => { const source = Bokeh.documents[0].get_model_by_name('time').renderers"
        ".map((each) => each.data_source).find((each) => each.columns().includes('correction'));"
        "return source.get_length() === 1 && [source.get_array('minute')[0], source.get_array('speed')[0]];"
        "})()"
    )
    minute, speed = dropped.until(lit)
    assert 0.0 < minute < dropped.box("time")["end"]
    assert 60.0 < speed < 250.0


def test_three_typed_legs_have_the_answer_of_the_command(browser: Browser, tmp_path: Path) -> None:
    browser.run(
        f"(() => {{ document.getElementById('byhand').open = true; const legs = {json.dumps(LEGS)};"
        "const rows = document.querySelectorAll('#typed tbody tr'); legs.forEach((leg, i) => leg.forEach("
        "(text, j) => { rows[i].querySelectorAll('input')[j + 1].value = text; }));"
        "document.getElementById('legs').requestSubmit(); })()"
    )
    legs = browser.until("state.legs && !state.status && state.legs")
    card = tmp_path / "legs.csv"
    card.write_text(download(browser, "legs"), encoding="utf-8")
    head, *rows = card.read_text(encoding="utf-8").splitlines()
    assert head == HEADINGS
    assert [row.split(",")[1] for row in rows] == ["3000"] * 3  # of 3,000 too
    (point,) = command("fixed-speed", card)["points"]
    assert f"{point['correction_kt']:+.2f}".replace("-", "−") in legs["tree"][0]["text"]
    points = tables(legs["tree"])[0]
    row = dict(zip(points["head"], points["rows"][0], strict=True))
    assert float(row["KTAS [kt]"]) == pytest.approx(point["true_airspeed_kt"], abs=0.05)
    assert browser.run("document.querySelector('#legsaid tbody').children.length") == 1


def test_a_number_alone_is_minutes_as_the_axis_is(browser: Browser) -> None:
    told = ["42", "42.5", "42,5", "42:10", "1:02:03", "", "end"]
    read = ["42:00", "42:30", "42:30", "42:10", "1:02:03", "", "end"]
    assert browser.run(f"{json.dumps(told)}.map(moment)") == read


def test_a_log_of_unknown_names_is_read_by_its_edited_draft(
    browser: Browser, log: Path, tmp_path: Path
) -> None:
    lines = log.read_text(encoding="utf-8").splitlines()
    head = next(i for i, line in enumerate(lines) if not line.startswith("#"))
    lines[head] = ",".join(
        f"q{i}" if i == 1 else f"my {name}" for i, name in enumerate(lines[head].split(","))
    )
    strange = tmp_path / "strange.csv"
    strange.write_text("\n".join(lines[head:]) + "\n", encoding="utf-8")
    theirs = log.read_text(encoding="utf-8").splitlines()[head].split(",")
    browser.choose_files([strange])
    draft = browser.until("state.chosen[0] === 1 && !state.status && state.draft")
    assert [row[0] for row in draft["rows"]] == lines[head].split(",")
    # Nothing of the flight before stands beside the draft.
    shown = (
        "document.getElementById('told').textContent + document.getElementById('rest').textContent"
    )
    assert browser.run(shown) == ""
    assert browser.run("document.getElementById('flight').hidden")
    quantity, _, unit = theirs[1].rpartition("_")
    browser.run(
        "(() => { const inputs = document.querySelectorAll('#columns tbody tr')[1].querySelectorAll('input');"
        f"inputs[0].value = {quantity!r}; inputs[1].value = {unit!r}; document.getElementById('map').click(); }})()"
    )
    browser.until("state.command.includes('--mapping mapping.toml')")
    state = browser.answered()
    assert state["answer"], state["refusal"]
    mapping = tmp_path / "mapping.toml"
    mapping.write_text(download(browser, "mapping"), encoding="utf-8")
    same(json.loads(download(browser, "json")), command("calibrate", strange, "--mapping", mapping))
    browser.run("document.querySelectorAll('#flights button')[0].click()")
    browser.until("state.chosen[0] === 0")
    browser.answered()


def test_names_from_outside_are_text(browser: Browser, tmp_path: Path) -> None:
    if os.name == "nt":
        pytest.skip("no such names on Windows")
    evil = tmp_path / "<img src=x onerror=document.title='evil'>.csv"
    evil.write_text("a\n1\n", encoding="utf-8")
    count = browser.run("state.flights.rows.length")
    browser.choose_files([evil])
    browser.until(f"state.flights.rows.length > {count} && !state.status")
    assert evil.name in browser.run("document.getElementById('flights').innerText")
    assert browser.run("document.querySelectorAll('img').length") == 0
    assert browser.run("document.title") == "pitotbench"
    browser.run("document.querySelectorAll('#flights button')[0].click()")
    browser.until("state.chosen[0] === 0")
    browser.answered()


def test_the_page_asks_no_other_host_and_breaks_no_rule(dropped: Browser, served: Served) -> None:
    kinds = (f"http://{served.host}/", f"ws://{served.host}/", "data:", "blob:")
    assert [each for each in dropped.requested if not each.startswith(kinds)] == []
    assert len([each for each in dropped.requested if each.startswith("ws:")]) >= 1
    assert dropped.wrong == []


def test_the_page_is_usable_on_a_phone(dropped: Browser) -> None:
    dropped.resize(400, 800)
    wide = "document.documentElement.scrollWidth <= 400"
    assert dropped.until(wide)
    dropped.resize(1200, 900)


def test_a_handbook_is_drawn_beside_the_curve_and_in_the_answer(
    dropped: Browser, log: Path, tmp_path: Path
) -> None:
    book = tmp_path / "poh.csv"
    book.write_text("KIAS,KCAS\n80,82\n120,121\n170,168\n", encoding="utf-8")
    dropped.choose_files([book])
    dropped.until("state.command.includes('--handbook poh.csv')")
    state = dropped.answered()
    found = json.loads(download(dropped, "json"))
    answer = command("calibrate", log, "--handbook", book)
    same(found, answer)
    assert found["handbook"] == answer["handbook"]
    assert answer["handbook"][0]["words"] in texts(state["answer"]["tree"], "sentence")
    row = state["compared"].index(True)
    dropped.run(
        f"document.querySelectorAll('#flights tbody tr')[{row}].querySelector('button').click()"
    )
    dropped.until("!state.command.includes('--handbook')")


def test_one_curve_from_several_logs_is_that_of_the_command(
    browser: Browser, log: Path, tmp_path: Path
) -> None:
    lines = log.read_text(encoding="utf-8").splitlines(keepends=True)
    head = next(i for i, line in enumerate(lines) if not line.startswith("#")) + 1
    half = (head + len(lines)) // 2
    parts = [tmp_path / "part1.csv", tmp_path / "part2.csv"]
    for path, rows in zip(parts, (lines[head:half], lines[half:]), strict=True):
        path.write_text("".join([*lines[:head], *rows]), encoding="utf-8")
    first = browser.run("state.flights.rows.length")
    browser.choose_files(parts)
    browser.until(f"state.flights.rows.length === {first + 2}")
    browser.run(
        "(() => { document.querySelectorAll('#flights input').forEach((box) => {"
        f"box.checked = Number(box.value) >= {first}; }});"
        "document.getElementById('choose').click(); })()"
    )
    browser.until("state.command === 'pitotbench calibrate part1.csv part2.csv'")
    assert browser.answered()["answer"], browser.run("state.refusal")
    for one, other in zip(
        json.loads(download(browser, "json")), command("calibrate", *parts), strict=True
    ):
        same(one, other)


def test_a_file_that_is_no_log_leaves_no_answer_of_another(
    dropped: Browser, tmp_path: Path
) -> None:
    picture = tmp_path / "cat.png"
    picture.write_bytes(b"no log")
    dropped.drop([picture])
    dropped.until("state.chosen.length === 0 && !state.status")
    assert "cat.png: no log" in dropped.run("document.getElementById('uploads').textContent")
    assert dropped.run("document.getElementById('told').textContent") == ""
    dropped.run("document.querySelectorAll('#flights button')[0].click()")
    dropped.until("state.chosen[0] === 0")
    dropped.answered()
