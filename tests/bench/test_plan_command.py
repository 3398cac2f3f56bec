"""`pitotbench plan`: the table, the document and the page say the same; the case that is written flies."""

import json
from itertools import count

import pytest

from pitotbench.cli.app import BAD_INPUT, DONE, command_line, main
from pitotbench.cli.plan import request_of
from pitotbench.records.case_file import read_case
from pitotbench.sensing.sampling import has_velocity_down

FEW = ["plan", "--maneuver", "figure_eight,step_both_ways", "--draws", "2", "--search", "0"]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plan")
    code = main([*FEW, "--want-kt", "0.2", "--minutes", "12", "--box-nm", "12", "--out", str(folder)])
    return code, folder


def test_a_page_and_a_case_are_written(written):
    code, folder = written
    assert code == DONE
    page = (folder / "plan.html").read_text(encoding="utf-8")
    axes = ("time recorded [min]", "mean ±2σ of the curve [kt]", "north [nmi]")
    for text in ("Pareto front", *axes, "figure_eight"):
        assert text in page
    assert "http" not in page.replace("http://www.w3.org", "")
    assert read_case(folder / "plan.toml").maneuver == "figure_eight"
    assert read_case(folder / "plan.toml").turbulence == "light"


def test_the_document_has_units_and_the_ranking(capsys):
    assert main([*FEW, "--json", "--want-kt", "0.1"]) == DONE
    document = json.loads(capsys.readouterr().out)
    assert document["best"] == "figure_eight"
    assert document["best_without_steep_turns"] == "step_both_ways"
    first, second = document["forecasts"]
    assert first["minutes_for_want"] == first["flights_for_want"] * first["minutes"]
    assert first["minutes_for_want"] < second["minutes_for_want"]
    assert 0.1 < first["two_sigma_kt"] < 0.3
    assert len(first["curve"]) == 13


def test_a_plan_in_a_pipe_says_how_far_it_is(monkeypatch, capsys):
    """A line for each maneuver and each flight of the search, were they all 20 s apart."""
    clock = count(0.0, 20.0)
    monkeypatch.setattr("pitotbench.bench.fleet.monotonic", lambda: next(clock))
    assert main(["plan", "--maneuver", "rapid_decel", "--draws", "2", "--search", "4"]) == DONE
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "pitotbench: flying: 1 of 5"
    assert len(lines) >= 5


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (["--das", "fast"], "unknown data system"),
        (["--speeds-kt", "100"], "LOW,HIGH"),
        (["--maneuver", "looping"], "unknown maneuver"),
        (["--wind-kt", "-3"], "0 to 100 kt"),
        (["--wind-kt", "nan"], "--wind-kt"),
        (["--wind-from-deg", "nan"], "--wind-from-deg"),
        (["--turbulence", "severe"], "turbulence"),
        (["--error-location", "wing"], "--error-location"),
        (["--receiver-height-m", "0.3"], "WHITE,SLOW"),
        (["--receiver-height-m=-1,2"], "from 0 to 1000 m"),
        (["--vertical-velocity", "yes"], "--vertical-velocity"),
    ],
)
def test_bad_flags_are_one_line(flags, says, capsys):
    assert main(["plan", *flags]) == BAD_INPUT
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1


def test_flags_state_the_receiver_and_the_location_of_the_error():
    flags = "--error-location static --receiver-height-m 0.3,2 --vertical-velocity recorded"
    request = request_of(command_line().parse_args(["plan", *flags.split()]))
    assert request.base.pressure_error.location == "static"
    assert (request.das.altitude_noise, request.das.altitude_drift) == (0.3, 2.0)
    assert has_velocity_down(request.das)
    assert request.base.das == request.das  # the case that is written flies the same receiver
