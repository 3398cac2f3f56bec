"""Logs of autopilots on the page: the same parameters to set as by the command."""

from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("bokeh", reason="the page needs Bokeh: pip install 'pitotbench[open]'")

from tests.lab import formats
from tests.logbook import foreign_files

from pitotbench.browser import work
from pitotbench.cli.app import main


@pytest.fixture(scope="module")
def flown() -> formats.Flown:
    """Both autopilots record one flight."""
    return formats.flight()


@pytest.mark.parametrize(("name", "autopilot"), [("a.bin", "ardupilot"), ("a.ulg", "px4")])
def test_the_parameters_of_a_drone_are_those_of_the_command(
    name: str, autopilot: str, flown: formats.Flown, tmp_path: Path
) -> None:
    if autopilot == "ardupilot":
        held = {"ARSPD_RATIO": 1.6, "ARSPD_OFFSET": 12.0, "ARSPD_TYPE": 1.0}
        path = foreign_files.dataflash(tmp_path / name, flown, held)
    else:
        held = {"ASPD_SCALE_1": 0.98, "SENS_DPRES_OFF": 12.0}
        path = foreign_files.ulog(tmp_path / name, flown, True, held)
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
    assert main(["calibrate", str(path), "--params", autopilot, "-o", str(out)]) == 0
    assert text == out.read_text(encoding="utf-8")
