"""Logs of autopilots on the page: the parameters to set of the command, without being asked for."""

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("bokeh", reason="the page needs Bokeh: pip install 'pitotbench[open]'")

from tests.lab import formats
from tests.logbook import foreign_files

from pitotbench.browser import work
from pitotbench.cli.app import main
from pitotbench.show.reader_units import BENCH


@pytest.fixture(scope="module")
def flown() -> formats.Flown:
    """Both autopilots record one flight."""
    return formats.flight()


@pytest.mark.parametrize(("name", "autopilot"), [("a.bin", "ardupilot"), ("a.ulg", "px4")])
def test_the_parameters_of_a_drone_are_those_of_the_command(
    name: str, autopilot: str, flown: formats.Flown, tmp_path: Path
) -> None:
    if autopilot == "ardupilot":
        held = {"ARSPD_RATIO": 1.3, "ARSPD_OFFSET": 12.0, "ARSPD_TYPE": 1.0}
        path = foreign_files.dataflash(tmp_path / name, flown, held)
    else:
        held = {"ASPD_SCALE_1": 0.89, "SENS_DPRES_OFF": 12.0}
        path = foreign_files.ulog(tmp_path / name, flown, True, held)
    replies: dict[str, Any] = {}
    tell = replies.__setitem__  # as of one child, which knows its latest answers
    work.find_flights(tell, path, {}, tmp_path / "none")
    (found,) = replies["found"]
    assert (found.flight.refusal, found.autopilot) == ("", autopilot)
    assert found.several == (autopilot == "ardupilot")  # and its second sensor is offered
    for number in ("1", "2") if found.several else ():
        log = work._part(path, work.Request(airspeed_sensor=number))
        assert log.header["airspeed_sensor"] == int(number)
    asked = work.Request(logs=(found.log,), parameters=found.autopilot)
    work.answer(tell, asked, True)
    answer = replies["answer"]
    assert answer.settings is not None
    work.take(tell, asked, "parameters", BENCH)
    shown, text = replies["file"]
    out = tmp_path / shown
    assert main(["calibrate", str(path), "--params", autopilot, "-o", str(out)]) == 0
    assert text == out.read_text(encoding="utf-8")
    # One ratio has one value: that of the table is that of the warning.
    gain = answer.settings.settings[0]
    (line,) = [each for each in answer.result.warnings if each.startswith("multiply")]
    assert f"as {gain.name} {gain.value:.5g} ± {gain.two_sigma:.2g} (old" in line
