"""Every error is one line and an exit code; no input is overwritten; no output is found impossible
too late.
"""

import gzip
import io
import json
import os
import re
import subprocess
import sys
from argparse import Namespace
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from numpy.linalg import LinAlgError
from tests.calibration import trajectories as fixture
from tests.logbook.bad_logs import BAD_LOGS
from tests.shared_data import real_log, shared_case

import pitotbench
from pitotbench.cli.app import guarded, main
from pitotbench.logbook.formats import FORMATS, write_log
from pitotbench.records import BadInputError, NoAnswerError

ROOT = Path(__file__).resolve().parents[2]
_POD = '[[effects]]\nname = "belly_pod"\nparameters = { drag_area_m2 = 0.1 }\n'


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "flight.csv"
    write_log(fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air()), path)
    return path


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text('maneuver = "rapid_decel"\n')
    return path


def refused(arguments, capsys, code=2):
    """The one line of a refusal."""
    assert main([str(part) for part in arguments]) == code
    found = capsys.readouterr()
    assert found.out == ""
    assert found.err.count("\n") == 1
    return found.err


@pytest.mark.parametrize(
    ("error", "code", "says"),
    [
        (BadInputError("no such thing"), 2, "no such thing"),
        (NoAnswerError("not observable"), 3, "not observable"),
        (FileNotFoundError(2, "No such file or directory", "x.csv"), 2, "x.csv: No such file"),
        (LinAlgError("SVD did not converge"), 3, "does not determine an answer: the numbers"),
        (ZeroDivisionError("division by zero"), 3, "does not determine an answer: the numbers"),
        (MemoryError("290 TiB for an array"), 2, "the memory does not suffice; check the clock"),
        (RecursionError("maximum depth"), 2, "nested too deeply"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (
            KeyError("swings"),
            1,
            "unexpected: KeyError: 'swings'; run again with --debug for the traceback",
        ),
        (RuntimeError("two\nlines"), 1, "RuntimeError: two lines"),
    ],
)
def test_every_error_is_one_line_and_an_exit_code(error, code, says, capsys):
    def run(_):
        raise error

    assert guarded(Namespace(run=run, debug=False)) == code
    found = capsys.readouterr()
    assert says in found.err
    assert found.err.count("\n") == 1
    assert found.out == ""
    if isinstance(error, ArithmeticError | LinAlgError | MemoryError | RecursionError):
        assert str(error) not in found.err  # no word of Python's


@pytest.mark.parametrize(
    "arguments", [["--debug", "calibrate", "no.csv"], ["calibrate", "no.csv", "--debug"]]
)
def test_debug_shows_the_traceback_of_any_error_before_or_behind_the_command(arguments, capsys):
    assert main(arguments) == 2
    assert "Traceback" in (error := capsys.readouterr().err)
    assert error.splitlines()[-1].startswith("pitotbench: no.csv")


def test_a_reader_that_closes_the_pipe_hears_nothing():
    legs = [
        "fixed-speed",
        "--ground-speed-kt",
        "178,185,188",
        "--track-deg",
        "178,82,355",
        "--json",
    ]
    command = [sys.executable, "-m", "pitotbench", *legs]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 1


@pytest.mark.parametrize("arguments", [["--version"], ["calibrate", "--version"]])
def test_version_names_the_bench_and_the_simulator(arguments, capsys):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 0
    assert (
        capsys.readouterr().out
        == f"pitotbench {pitotbench.__version__}, JSBSim {version('jsbsim')}\n"
    )


@pytest.mark.parametrize(
    "stated", [("--from", "90:00"), ("--from", "2:00", "--to", "1:00"), ("--to", "noon")]
)
def test_a_part_that_the_log_does_not_hold_is_refused_with_its_times(stated, log, capsys):
    assert main(["calibrate", str(log), *stated]) == 2
    assert "0:00 to 3:56" in (says := capsys.readouterr().err) or "such as 12:30" in says


def test_a_stated_part_is_the_log_of_its_rows(log, capsys):
    assert main(["calibrate", str(log), "--from", "0:20", "--to", "0:03:40", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    (window,) = answer["winds"]
    assert 20.0 <= window["from_s"] < window["to_s"] <= 220.0
    assert answer["usable"] is True
    assert answer["disagreements"] == []


@pytest.mark.parametrize("report", ["", ".", "page.csv", "no-folder/page.html", "/proc/page.html"])
def test_a_report_is_refused_before_the_work_and_overwrites_no_log(
    report, log, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    error = refused(["calibrate", "no-such-log.csv", "--report", report], capsys)
    assert "no-such-log" not in error
    assert list(tmp_path.iterdir()) == []
    before = log.read_bytes()
    assert ".html" in refused(["calibrate", log, "--report", log], capsys)
    assert log.read_bytes() == before


@pytest.mark.parametrize("out", ["x.xlsx", ".", "no-folder/x.csv", "/proc/x.csv", "case.toml"])
def test_a_log_that_cannot_be_written_is_refused_before_the_flight(out, case, monkeypatch, capsys):
    monkeypatch.chdir(case.parent)
    monkeypatch.setattr(
        "pitotbench.campaigns.flights.fly_to_log", lambda *_: pytest.fail("it was flown")
    )
    assert str(out) in refused(["fly", case, "-o", out], capsys)


@pytest.mark.parametrize(
    "command",
    [
        ["plan"],
        ["campaign", "--maneuver", "circle", "--das", "20/1"],
        ["reconcile", "no-such-log.csv"],
    ],
    ids=lambda command: command[0],
)
@pytest.mark.parametrize("out", ["taken", "taken/below", "/proc/out"])
def test_a_folder_that_cannot_be_made_is_refused_before_the_work(
    command, out, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").write_text("mine")
    assert out in refused([*command, "--out", out], capsys)
    assert (tmp_path / "taken").read_text() == "mine"


def test_a_reconciliation_does_not_overwrite_its_card(log, case, capsys):
    card = case.rename(case.with_name("patch.toml"))
    # A script may still leave out the next flight, which is no longer planned.
    error = refused(
        ["reconcile", log, "--card", card, "--out", card.parent, "--no-next-flight"], capsys
    )
    assert "patch.toml: this is an input" in error


@pytest.mark.parametrize(
    ("name", "says"),
    [
        *((f"flight{suffix}", "not a case; a case is a TOML file") for suffix in FORMATS),
        ("none.toml", "none.toml: cannot be read as a case file: No such file or directory\n"),
    ],
)
def test_what_is_no_case_is_called_what_it_is(name, says, tmp_path, capsys):
    path = tmp_path / name
    if path.suffix in FORMATS:
        path.write_bytes(b"time_s\n0\n")
    assert says in refused(["fly", path, "-o", tmp_path / "x.csv"], capsys)


@pytest.mark.parametrize(
    "text", ["x = " + "[" * 3000, "x = " + "1" * 5000, ".".join("x" * 30_000) + " = 1"]
)
def test_a_monstrous_case_or_mapping_is_refused(text, case, log, capsys):
    case.write_text(text)
    assert "not valid TOML" in refused(["fly", case, "-o", case.with_name("x.csv")], capsys)
    assert "not valid TOML" in refused(["calibrate", log, "--mapping", case], capsys)
    os.mkfifo(pipe := case.with_name("pipe.toml"))
    assert "not a regular file" in refused(["calibrate", log, "--mapping", pipe], capsys)


def rows_of(log):
    """The lines of the log without its header."""
    return [line for line in log.read_text().splitlines() if not line.startswith("#")]


@pytest.mark.parametrize("stated", ["accuracy = 5", 'accuracy = "a"', "accuracy = [1]"])
def test_an_accuracy_in_the_header_that_is_no_table_is_refused(stated, log, tmp_path, capsys):
    path = tmp_path / "odd.csv"
    path.write_text("\n".join([f"# {stated}", *rows_of(log)]))
    assert "accuracy" in refused(["calibrate", path], capsys)


@pytest.mark.parametrize("effects", ["", _POD], ids=["JSBSim", "effects"])
@pytest.mark.parametrize("text", ["<fdm_config", "<a></b>", "", "<fdm_config/>"])
def test_an_aircraft_file_that_is_broken_is_refused(text, effects, case, monkeypatch, capsys):
    monkeypatch.chdir(case.parent)
    folder = case.parent / "aircraft" / "broken"
    folder.mkdir(parents=True)
    (folder / "broken.xml").write_text(text)
    case.write_text(f'maneuver = "rapid_decel"\naircraft = "broken"\n{effects}')
    assert "aircraft" in refused(["fly", case, "-o", "x.csv"], capsys)


def test_names_from_a_log_reach_the_terminal_as_they_are_written(log, tmp_path, capsys):
    """Neither rich markup nor escape codes of a column or file name act; both can be read."""
    path = tmp_path / "[red]a[bold] :bomb:\x1b[31m.csv"
    head, *rows = rows_of(log)
    path.write_text(
        "\n".join([f"{head},[bold red]x[/bold]\x1b]0;title\x07", *(f"{row},1" for row in rows)])
    )
    assert main(["calibrate", str(path), "--model", "bias", "-v"]) == 0
    text = capsys.readouterr().out
    assert "[red]a[bold] :bomb:\\x1b[31m.csv" in text
    assert "[bold red]x[/bold]\\x1b]0;title\\x07" in text
    assert "\x1b" not in text
    error = refused(["calibrate", tmp_path / "\x1b[31mred.csv"], capsys)
    assert "\\x1b[31mred.csv" in error
    assert "\x1b" not in error


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_a_terminal_that_lacks_letters_gets_others(encoding, log, monkeypatch):
    screen = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    monkeypatch.setattr(sys, "stdout", screen)
    assert main(["calibrate", str(log), "--model", "bias"]) == 0
    screen.flush()
    shown = screen.buffer.getvalue().decode(encoding)
    assert re.search(r"Add [-+]\d\.\d\d (\+/-|±) \d\.\d\d kt", shown)
    assert "?" not in shown.partition("\n")[0]


def test_a_closed_terminal_gets_nothing(log, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "stdout", None)
    assert main(["calibrate", str(log), "--model", "bias", "--json"]) == 0
    sys.stdout.close()


def test_a_file_name_that_is_not_utf_8_reaches_the_page(log, tmp_path, capsys):
    path, page = tmp_path / "flight\udcff.csv", tmp_path / "page.html"
    path.write_bytes(log.read_bytes())
    assert main(["calibrate", str(path), "--model", "bias", "--report", str(page)]) == 0
    assert "flight\\udcff.csv" in capsys.readouterr().out
    assert "flight?.csv" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize("flags", [[], ["--debug"]])
def test_only_debug_shows_the_warnings_of_python(flags, tmp_path):
    """A user reads no line of source; the tests of this project raise them as errors."""
    (tmp_path / "sitecustomize.py").write_text(
        "import atexit, warnings; atexit.register(lambda: warnings.warn('told', UserWarning, "
        "stacklevel=2))"
    )
    command = [sys.executable, "-m", "pitotbench", "calibrate", "no.csv", *flags]
    settings = os.environ | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT / 'src'}"}
    said = subprocess.run(command, capture_output=True, text=True, env=settings, cwd=tmp_path)
    assert said.returncode == 2
    assert ("told" in said.stderr) == bool(flags)


# What a reader is asked to do: a refusal ends with one of these, whatever its cause.
WAY_OUT = re.compile(
    r"[;:,.?(] ?(and |or )?(check|clear|copy|correct|cut|fly|give|keep|load|mend|name|record|remove|"
    r"rename|repair|save|shorten|sort|swap|unpack|use|write|a log with other names|pip install)\b",
    re.IGNORECASE,
)


@pytest.mark.parametrize("name", list(BAD_LOGS))
def test_a_bad_log_is_refused_in_one_line_with_its_cause_and_a_way_out(name, tmp_path, capsys):
    (make, says), page = BAD_LOGS[name], tmp_path / "page.html"
    said = refused(["calibrate", make(tmp_path), "--json", "--report", page], capsys)
    assert re.search(says, said)
    assert WAY_OUT.search(said)
    assert not page.exists()


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (["--mach-max", "nan"], "the Mach limit is nan: it must be above zero"),
        (["--mach-max", "-1"], "the Mach limit is -1: it must be above zero"),
        (["--latency", "1000"], "a latency of 1000 s: give at most 10 s"),
        (["--latency", "nan"], "a latency of nan s"),
        (["--ground-speed-min-kt", "-3"], "not negative"),
    ],
)
def test_a_limit_that_no_log_can_have_is_named(flags, says, log, capsys):
    assert says in refused(["calibrate", log, *flags], capsys)


CASES = "reliability"


@pytest.mark.parametrize(
    ("command", "name", "says"),
    [
        ("calibrate", "igc-date.igc", "1 different positions"),
        ("calibrate", "igc-extension.igc", "1 different positions"),
        ("calibrate", "igc-extension2.igc", "2 different positions"),
        ("calibrate", "bin-labels.bin", "copy it again from its source"),
        ("calibrate", "mat-object.mat", "'time_s' is left out: its cells"),
        ("map", "mat-object.mat", "'time_s' is left out: its cells"),
        ("fixed-speed", "card-zero-temperature.csv", "row 6: air_temperature_degc is -1e+308"),
        ("compare", "calibration-text.json", "correction_kt of point 2 of the curve"),
        ("compare", "calibration-empty.json", "holds no point"),
    ],
)
def test_a_small_input_that_is_wrong_is_refused_with_its_place(command, name, says, capsys):
    pytest.importorskip("pymavlink", reason="needs the extra pitotbench[logs]")
    path = shared_case(CASES, name)
    found = refused([command, path, *([path] if command == "compare" else [])], capsys)
    assert says in found
    assert name in found


@pytest.mark.parametrize("flag", ["--to", "--ground-speed-min-kt", "--params", "--report"])
def test_a_flag_whose_value_is_two_dashes_is_refused(flag, log, capsys):
    with pytest.raises(SystemExit) as stop:
        main(["calibrate", str(log), f"{flag}=--"])
    assert stop.value.code == 2
    assert f"argument {flag}: expected one argument" in capsys.readouterr().err


@pytest.mark.parametrize("suffix", [".csv", ".mat", ".igc", ".bin", ".json", ".csv.gz"])
@pytest.mark.parametrize("command", ["calibrate", "compare", "map", "fixed-speed", "fly"])
def test_a_pipe_for_a_file_is_refused_and_not_waited_for(suffix, command, tmp_path, capsys):
    path = tmp_path / f"log{'.toml' if command == 'fly' else suffix}"
    os.mkfifo(path)
    more = {"compare": [path], "fly": ["-o", tmp_path / "out.csv"]}.get(command, [])
    found = refused([command, path, *more], capsys)
    assert path.name in found


RAMP = {
    "time_s": np.arange(120.0),
    "indicated_airspeed_kt": np.zeros(120),
    "pressure_altitude_ft": 860.0 + np.arange(120.0) % 3,
    "air_temperature_degc": np.full(120, 20.0),
    "ground_speed_kt": np.interp(np.arange(120.0), [0, 40, 90, 120], [0, 4, 13, 5]),
    "track_deg": np.arange(120.0),
}
ROLL = {**RAMP, "indicated_airspeed_kt": np.maximum(0.0, np.arange(120.0) - 95.0) * 2.5 + 0.01}
ROLL |= {"ground_speed_kt": np.maximum(3.0, ROLL["indicated_airspeed_kt"])}


@pytest.mark.parametrize(
    ("table", "command"), [(RAMP, "inspect"), (RAMP, "calibrate"), (ROLL, "calibrate")]
)
def test_a_log_without_level_flight_says_so(table, command, tmp_path, capsys):
    rows = zip(*(values.tolist() for values in table.values()), strict=True)
    path = tmp_path / "ramp.csv"
    path.write_text("\n".join([",".join(table), *(",".join(map(str, row)) for row in rows)]) + "\n")
    assert "no level flight" in refused([command, path], capsys)


def test_a_recorder_that_was_on_for_the_ramp_and_the_roll_alone_says_so(tmp_path, capsys):
    packed = real_log("garmin", "c172s-g1000-2011.csv.gz").read_bytes()
    lines = gzip.decompress(packed).splitlines()
    (tmp_path / "ramp.csv").write_bytes(b"\n".join(lines[:903]) + b"\n")
    assert "no level flight" in refused(["calibrate", tmp_path / "ramp.csv"], capsys)


@pytest.mark.parametrize("above", ['#airframe_info, airframe_name="{}"', "# aircraft = '{}'"])
def test_the_logs_of_two_airplanes_are_not_joined(above, log, tmp_path, capsys):
    rows = rows_of(log)
    for name, airplane in (("a", "Cessna 172S"), ("b", "PA-28-181"), ("c", "CESSNA 172S ")):
        text = "\n".join([above.format(airplane), *rows]) + "\n"
        (tmp_path / f"{name}.csv").write_text(text)
    one, other, same = (tmp_path / f"{name}.csv" for name in "abc")
    found = refused(["calibrate", one, other], capsys)
    assert "two airplanes, 'Cessna 172S' and 'PA-28-181'" in found
    assert "--separately" in found
    found = refused(
        ["reconcile", one, other, "--aircraft", "none", "--out", tmp_path / "o"], capsys
    )
    assert "two airplanes" in found
    for logs in ((one, same), (one, other, "--separately")):
        assert main(["calibrate", *map(str, logs), "--model", "bias"]) == 0
    capsys.readouterr()


@pytest.mark.parametrize(
    ("flag", "value", "way_out"),
    [
        ("--accuracy", "temperature_k=3", "give a card of legs"),
        ("--accuracy", "", "give a card of legs"),
        ("--mapping", "g1000", "leave it out"),
        ("--table", "curve.csv", "calibrate LOG --table"),
        ("--set", "gust_mps=1", "points tables"),
    ],
)
def test_a_flag_that_does_nothing_for_typed_legs_is_refused(flag, value, way_out, capsys):
    typed = ["--ground-speed-kt", "178,185,188", "--track-deg", "178,82,355"]
    found = refused(["fixed-speed", *typed, flag, value], capsys)
    assert f"{flag} does nothing for typed legs" in found
    assert way_out in found


@pytest.mark.parametrize("flags", [["--json"], ["--units", "km/h"]], ids=" ".join)
def test_a_flag_that_does_nothing_for_a_sheet_is_refused(flags, tmp_path, capsys):
    sheet = tmp_path / "sheet.html"
    found = refused(["fixed-speed", "--sheet", sheet, *flags], capsys)
    assert f"{flags[0]} does nothing for a sheet" in found
    assert not sheet.exists()


def test_a_value_may_begin_with_a_minus_sign(capsys):
    """Behind the flag or joined to it, alike: here a ground speed that cannot be."""
    for speeds in (["--ground-speed-kt", "-178,185,188"], ["--ground-speed-kt=-178,185,188"]):
        found = refused(["fixed-speed", *speeds, "--track-deg", "-178,82,355"], capsys)
        assert "ground speed" in found
