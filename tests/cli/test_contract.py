"""The page of the contract against real answers, the Python names and the exit codes."""

import json
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

import pitotbench
from pitotbench import write_log
from pitotbench.cli import shared_flags
from pitotbench.cli.app import COMMANDS, main
from pitotbench.records.linear_model import LinearModel, Mode
from pitotbench.records.performance import Performance
from pitotbench.show.inspection import performance_json
from pitotbench.show.linear_model import linear_json

# Several voices of one answer are looked at: each log is fitted once.
pytestmark = pytest.mark.usefixtures("one_fit_of_each_log")

PAGE = (Path(__file__).parents[2] / "docs" / "contract.md").read_text(encoding="utf-8")
ANSWERS = {
    row[0]: re.findall(r"`(\w+)`", row[1])
    for row in re.findall(r"^\| (`[^|]+) \| ([^|]+) \|$", PAGE.partition("## JSON")[2], re.M)
}

_FIRST = {  # the arguments and flags of version 1.0.0
    "fly": "case -o --out --truth",
    "calibrate": "logs --model --mapping --from --to --without --temperature-c --airspeed-sensor "
    "--accuracy --set --mach-max --ground-speed-min-kt --on-condition --no-down "
    "--no-altitude --method --error-location --wind --latency --all-rows --separately -v "
    "--verbose --limit --params -o --handbook --card --report --record --table --units "
    "--json",
    "compare": "first second --mapping --accuracy --json --report --units --model --card --tolerance",
    "inspect": "log --mapping --airspeed-sensor --units --json --report",
    "map": "log -o --out",
    "fixed-speed": "logs --mapping --accuracy --set --table --units --json --ground-speed-kt --track-deg "
    "--sheet",
    "aircraft": "action aircraft --maneuver --seed --report --handbook --linear --json --units --out "
    "--configuration",
    "campaign": "plan --maneuver --das --model --method --turbulence --wind-kt --wind-from-deg "
    "--units --pilot --aircraft --seeds --log-format --out --jobs --scheduler --security "
    "--shard --time-limit --memory-limit --keep-logs --no-report --retry-failed "
    "--progress --dry-run",
    "results": "folders --where --state --columns --by --limit --draw --page --out",
    "open": "logs --port --no-browser",
    "reconcile": "log --aircraft --holdout --mapping --from --to --without --record --units --json "
    "--card --no-next-flight --terms --apply --close --no-cache -v --verbose --out",
    "plan": "--das --turbulence --wind-kt --wind-from-deg --units --json --speeds-kt "
    "--error-location --receiver-height-m --vertical-velocity --minutes --want-kt "
    "--box-nm --maneuver --aircraft --draws --search --by-hand --sheet --out",
    "completion": "shell",
}


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("contract") / "flight.csv"
    return write_log(fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air()), path)


def answer(capsys: pytest.CaptureFixture[str], *words: object) -> dict:
    assert main([*map(str, words), "--json"]) == 0
    return json.loads(capsys.readouterr().out, parse_constant=pytest.fail)


def require_keys(name: str, *found: dict) -> None:
    assert found
    for each in found:
        assert set(ANSWERS[name]) <= set(each), (name, set(ANSWERS[name]) - set(each))


def test_a_calibration_and_the_comparison_of_two_have_the_keys(log, tmp_path, capsys):
    found = answer(capsys, "calibrate", log)
    assert found["schema"] == 1
    require_keys("`calibrate`", found)
    require_keys("`calibrate`, in `curve`", *found["curve"])
    require_keys("`calibrate`, in `parameters`", *found["parameters"])
    require_keys("`calibrate`, in `wind`", found["wind"])
    kept = tmp_path / "answer.json"
    kept.write_text(json.dumps(found), encoding="utf-8")
    compared = answer(capsys, "compare", kept, kept)
    assert compared["schema"] == 1
    require_keys("`compare` of calibrations", compared)
    several = answer(capsys, "calibrate", log, log, "--separately")
    assert [each["schema"] for each in several] == [1, 1]


def test_legs_have_the_keys(capsys):
    typed = "--ground-speed-kt", "178,185,188,184", "--track-deg", "178,82,355,265"
    found = answer(capsys, "fixed-speed", *typed)
    assert found["schema"] == 1
    require_keys("`fixed-speed` of legs", found)


def test_an_inspection_and_a_plan_have_the_keys(log, tmp_path, capsys):
    require_keys("`inspect`", answer(capsys, "inspect", log))
    for name in ("one.csv", "other.csv"):
        (tmp_path / name).write_bytes(log.read_bytes())
    held = answer(capsys, "inspect", tmp_path)
    assert [each["file"] for each in held] == ["one.csv", "other.csv"]
    require_keys("`inspect` of several flights", *held)
    few = "--maneuver", "rapid_decel", "--draws", "2", "--search", "0"
    require_keys("`plan`", answer(capsys, "plan", *few))
    require_keys("`plan --by-hand`", answer(capsys, "plan", "--by-hand"))


def test_a_reconciliation_has_the_keys(capsys, tmp_path):
    """Of a late GPS receiver, judged without an airplane: no flight is flown for it."""
    case = tmp_path / "late.toml"
    case.write_text(
        'maneuver = "decel_circle"\n[das]\nair_rate_hz = 20\ngps_rate_hz = 5\n[[effects]]\nname = "gps_latency"\n'
        "parameters = { latency_s = 0.8 }\n",
        encoding="utf-8",
    )
    late = tmp_path / "late.csv"
    assert main(["fly", str(case), "-o", str(late)]) == 0
    bare = pitotbench.read_log(late)  # without its header it has no card, and so no null flights
    plain = write_log(type(bare)(**{**_fields(bare), "header": {}}), tmp_path / "plain.csv")
    capsys.readouterr()
    found = answer(capsys, "reconcile", plain, "--aircraft", "none")
    assert found["schema"] == 1
    require_keys("`reconcile`", found)
    require_keys("`reconcile`, in `gaps`", *found["gaps"])
    require_keys("`reconcile`, in `causes`", *(c for gap in found["gaps"] for c in gap["causes"]))


def _fields(record: object) -> dict:
    return {name: getattr(record, name) for name in record.__dataclass_fields__}


def test_the_page_lists_the_public_names_and_the_exit_codes():
    section = PAGE.partition("## Python")[2].partition("\n## ")[0]
    named = re.findall(r"`(\w+)`", " ".join(re.findall(r"^\|.*", section, re.M)))
    assert sorted(named) == sorted(pitotbench.__all__)
    codes = [int(code) for code in re.findall(r"^\| (\d+) \|", PAGE, re.M)]
    names = ("DONE", "UNFORESEEN", "BAD_INPUT", "NO_ANSWER", "INTERRUPTED")
    assert codes == [getattr(shared_flags, name) for name in names]


def test_the_performance_of_an_airplane_has_the_keys():
    require_keys("`aircraft performance`", performance_json(Performance("x", 1.0, (), ())))


def test_the_linear_model_of_an_airplane_has_the_keys():
    told = linear_json(
        LinearModel(
            aircraft="x",
            mass=1.0,
            height=1.0,
            calibrated_airspeed=1.0,
            roll_acceleration=0.0,
            states={"P": "rad/s"},
            inputs={"DaCmd": "norm"},
            trim=np.zeros(1),
            setting=np.zeros(1),
            system_matrix=-np.eye(1),
            input_matrix=np.eye(1),
            modes=(Mode("roll", -1.0 + 0.0j),),
        )
    )
    require_keys("`aircraft performance --linear`", told)
    require_keys("`aircraft performance --linear`, in `modes`", *told["modes"])


def test_every_argument_and_flag_of_the_first_version_is_still_there():
    lost = {}
    for row in COMMANDS:
        now = {name for each in import_module(row.module).FLAGS for name in each.names}
        lost[row.name] = {*_FIRST[row.name].split()} - now
    assert {*lost} == {*_FIRST}
    assert {name: words for name, words in lost.items() if words} == {}


_ONE_FIELD = """
import sys
from dataclasses import dataclass
from pathlib import Path
from pitotbench.records import calibration_request as asked

@dataclass(frozen=True, slots=True)
class More(asked.CalibrationChoices):
    static_lag: float = asked.option(0.0, "--static-lag-ms", "lag of the static line", "ms", type=float)
    no_ram: bool = asked.option(False, "--no-ram", "without the ram rise")

asked.CalibrationChoices = More  # as if its fields stood there

from pitotbench.bench import calibrations
from pitotbench.browser import work
from pitotbench.calibration.options import CalibrationOptions, choices_of
from pitotbench.cli import app
from pitotbench.cli.shared_flags import stated_choices
from pitotbench.records.log import Choice
from pitotbench.show.reader_units import BENCH

parser = app.command_line()
given = parser.parse_args(["calibrate", "a.csv", "--static-lag-ms", "250", "--no-ram"])
flags = stated_choices(given)
assert flags == {"static_lag": 0.25, "no_ram": True}, flags
options = calibrations.options_of((), None, **flags)  # the keywords of Python
assert options.static_lag == 0.25 and options.no_ram
record = calibrations.settings_of(options, flags, ())
assert Choice("static_lag", "250 ms", "stated") in record, record
assert Choice("no_ram", "yes", "stated") in record, record
told = dict.fromkeys(work.SETTINGS, "") | {"static_lag": "250", "no_ram": "yes"}
page = work.Request(logs=(asked.NamedFile(Path("a.csv"), "a.csv"),), **work.fields_of(told))
line = page.command(BENCH)
assert line == "pitotbench calibrate a.csv --static-lag-ms 250 --no-ram", line
assert choices_of(dict(page.options)) == flags
from pitotbench.browser.words import settings_told
shown = settings_told()["static_lag"]
assert (shown["flag"], shown["unit"]) == ("--static-lag-ms", "ms"), shown
parser.parse_args(["calibrate", "--help"])
"""


def test_an_option_of_the_calibration_is_one_field_of_its_record():
    """Two fields more, and no other line: they are flags with help and unit, keywords of Python,
    settings of the page, and lines of the record.
    """
    done = subprocess.run(
        [sys.executable, "-c", _ONE_FIELD], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "lag of the static line [ms]" in " ".join(done.stdout.split())
    assert "without the ram rise" in done.stdout
