"""Real logs on the page in a real browser: their answers are those of the command."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("bokeh", reason="the page needs Bokeh: pip install 'pitotbench[open]'")

from tests.browser.chromium import Browser, Served, program, texts
from tests.browser.test_in_chromium import command, download, same, type_minutes
from tests.shared_data import real_log

from pitotbench.show.columns import with_minus_signs


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    program()
    page = Served()
    with Browser(tmp_path_factory.mktemp("browser")) as tab:
        tab.open(page.address)
        yield tab
    page.close()


# The whole of an hour; parts of the others, which are long.
@pytest.mark.parametrize(
    ("folder", "name", "begin", "end"),
    [
        ("garmin", "c172s-g1000-2011.csv.gz", "", ""),
        ("garmin", "pa28-gifd-2024.csv.gz", "40:00", "60:00"),
        ("citation", "2019-03-12.parquet", "20:00", "30:00"),
    ],
)
def test_a_real_log_has_the_answer_of_the_command(
    folder: str, name: str, begin: str, end: str, browser: Browser, tmp_path: Path
) -> None:
    path = real_log(folder, name)
    count = browser.run("state.flights.rows.length")
    browser.drop([path])
    browser.until(f"state.flights.rows.length > {count} && state.command.endsWith({name!r})")
    part = ["--from", begin, "--to", end] if begin else []
    if begin:
        type_minutes(browser, begin, end)
    state = browser.answered()
    answer = command("calibrate", path, *part)
    told = [line.lower() for line in texts(state["answer"]["tree"], "doubt", "notice")]
    wanted = [with_minus_signs(each).lower() for each in answer["warnings"]]
    assert [each for each in wanted if not any(each in line for line in told)] == []
    same(json.loads(download(browser, "json")), answer)
