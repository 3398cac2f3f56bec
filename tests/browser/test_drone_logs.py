"""Logs of autopilots on the page: the same parameters to set as by the command."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("bokeh", reason="the page needs Bokeh: pip install 'pitotbench[open]'")

from tests.browser.chromium import child_environment
from tests.lab.formats import flight
from tests.logbook import foreign_files

from pitotbench.browser import work


@pytest.mark.parametrize(("name", "autopilot"), [("a.bin", "ardupilot"), ("a.ulg", "px4")])
def test_the_parameters_of_a_drone_are_those_of_the_command(
    name: str, autopilot: str, tmp_path: Path
) -> None:
    if autopilot == "ardupilot":
        held = {"ARSPD_RATIO": 1.6, "ARSPD_OFFSET": 12.0, "ARSPD_TYPE": 1.0}
        path = foreign_files.dataflash(tmp_path / name, flight(), held)
    else:
        held = {"ASPD_SCALE_1": 0.98, "SENS_DPRES_OFF": 12.0}
        path = foreign_files.ulog(tmp_path / name, flight(), True, held)
    (found,) = next(work.find_flights(path, {}, tmp_path / "none"))
    assert not found.flight.refusal
    asked = work.Request((found.log,))
    *_, plain = work.answer(asked, True)
    assert isinstance(plain, work.Answer)
    assert plain.settings is None
    with_parameters = replace(asked, autopilot=autopilot)
    *_, answer = work.answer(with_parameters, False)
    assert isinstance(answer, work.Answer)
    assert answer.settings is not None
    ((shown, text),) = work.take(with_parameters, "parameters")
    out = tmp_path / shown
    words = [
        sys.executable,
        "-m",
        "pitotbench",
        "calibrate",
        path,
        "--params",
        autopilot,
        "-o",
        out,
    ]
    subprocess.run([*map(str, words)], check=True, capture_output=True, env=child_environment())
    assert text == out.read_text(encoding="utf-8")
