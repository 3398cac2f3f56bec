"""The command line's contract: what it prints and completes, its exit codes, nothing half-written."""

import json
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import BadInputError, CalibrationOptions, Case, read_log, write_log
from pitotbench.calibration import calibrate
from pitotbench.campaigns.plan_file import plan_of_names
from pitotbench.cli.app import COMMANDS, command_line, main
from pitotbench.cli.plan import request_of as plan_request
from pitotbench.pressure_error.models import SMOOTH
from pitotbench.show.calibration import short_answer_of
from pitotbench.simulation.maneuvers import MANEUVERS, PAPER_MANEUVERS, maneuvers_named
from pitotbench.units import DEGREE, KNOT

CURVE_KEYS = {
    "indicated_airspeed_kt", "correction_kt", "two_sigma_kt", "white_two_sigma_kt", "normalized_pressure_error",
    "normalized_two_sigma", "simultaneous_two_sigma_kt", "calibrated_airspeed_kt",
}  # fmt: skip
WIND_KEYS = {
    "north_kt", "east_kt", "down_kt", "north_two_sigma_kt", "east_two_sigma_kt", "down_two_sigma_kt",
}  # fmt: skip


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "flight.csv"
    return write_log(fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air()), path)


def test_calibrate_json_holds_the_contract(log, capsys):
    """It is strict: this log says nothing of the latency, so that its bound is infinite."""
    assert main(["calibrate", str(log), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    keys = {
        "model",
        "parameters",
        "wind",
        "curve",
        "residual_two_sigma_kt",
        "samples",
        "converged",
        "warnings",
    }
    assert keys <= set(answer)
    assert set(answer["wind"]) == WIND_KEYS
    assert all(set(point) == CURVE_KEYS for point in answer["curve"])
    assert [p["name"] for p in answer["parameters"]] == list(SMOOTH.parameter_names)
    middle = answer["curve"][len(answer["curve"]) // 2]
    truth = (
        fixture.true_correction(np.array([middle["indicated_airspeed_kt"]]) * 1852 / 3600)[0]
        * 3600
        / 1852
    )
    assert abs(middle["correction_kt"] - truth) < 2 * middle["two_sigma_kt"]


def test_calibrate_prints_units_and_writes_a_page(log, tmp_path, capsys):
    page = tmp_path / "page.html"
    assert main(["calibrate", str(log), "--model", "quadratic", "--report", str(page)]) == 0
    assert "[kt]" in capsys.readouterr().out
    assert "<svg" in page.read_text(encoding="utf-8")


def test_fixed_speed_of_a_log_and_beside_the_curve(tmp_path, capsys):
    rate = 10
    heading = np.linspace(0.0, 400.0, 90 * rate) * np.pi / 180.0
    speed = np.concatenate(
        [np.full(90 * rate, 55.0), np.linspace(55.0, 75.0, 60 * rate), np.full(90 * rate, 75.0)]
    )
    path = speed, np.concatenate([heading, np.full(60 * rate, heading[-1]), heading])
    name = tmp_path / "turns.csv"
    write_log(fixture.fly(path, rate, rate, fixture.Air()), name)
    assert main(["fixed-speed", str(name), "--json"]) == 0
    points = json.loads(capsys.readouterr().out)["fixed_speed"]
    assert [point["method"] for point in points] == ["turn", "turn"]
    assert main(["calibrate", str(name), "--model", "linear", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["fixed_speed"] == points
    assert main(["fixed-speed", str(name)]) == 0
    assert "[kt]" in capsys.readouterr().out
    assert (
        main(["fixed-speed", str(name), str(name), "--accuracy", "temperature_k=3", "--json"]) == 0
    )
    one, other = (document["fixed_speed"] for document in json.loads(capsys.readouterr().out))
    assert one == other
    assert all(
        wide["two_sigma_kt"] > point["two_sigma_kt"]
        for wide, point in zip(one, points, strict=True)
    )


def test_fixed_speed_wants_a_log_with_legs_or_typed_legs(log, capsys):
    for flags in (
        "",
        "--track-deg 1,2,3",
        "x.csv --track-deg 1",
        "--ground-speed-kt a --track-deg 1",
    ):
        assert main(["fixed-speed", *flags.split()]) == 2
        assert "--ground-speed-kt" in capsys.readouterr().err
    assert main(["fixed-speed", str(log)]) == 3
    assert "four legs" in capsys.readouterr().err
    # The worked example of four legs.
    assert (
        main(
            [
                "fixed-speed",
                "--ground-speed-kt",
                "178,185,188,184",
                "--track-deg",
                "178,82,355,265",
                "--json",
            ]
        )
        == 0
    )
    answer = json.loads(capsys.readouterr().out)
    assert answer["true_airspeed_kt"] == pytest.approx(183.7267, abs=5e-5)
    assert answer["spread_kt"] == pytest.approx(0.8271, abs=5e-5)
    typed = ["--ground-speed-kt", "178,185,188,184", "--track-deg", "178,82,355,265"]
    assert main(["fixed-speed", *typed]) == 0
    told, wind = capsys.readouterr().out.splitlines()
    assert told == (
        "The true airspeed is 183.7 kt; its answers of three legs each spread by 0.8 kt."
    )
    by_json = (answer["wind_speed_kt"], answer["wind_from_deg"])
    assert wind == "The wind is {:.1f} kt from {:03.0f}°.".format(*by_json)


def test_fly_gives_a_small_airplane_the_usual_curve_at_its_own_speeds(tmp_path, capsys):
    case, log = tmp_path / "case.toml", tmp_path / "log.csv"
    case.write_text('aircraft = "aerosonde"\nmaneuver = "rapid_decel"\n', "utf-8")
    assert main(["fly", str(case), "-o", str(log)]) == 0
    assert len(read_log(log)) > 1000  # the navajo's own curve ends far above its airspeeds


def test_fly_writes_a_log_without_truth(tmp_path, capsys):
    case = tmp_path / "case.toml"
    case.write_text(
        'maneuver = "rapid_decel"\nturbulence = "none"\n[pressure_error]\nparameters = [0.012345, '
        "0.0, 0.0]\n"
    )
    out = tmp_path / "log.csv"
    assert main(["fly", str(case), "-o", str(out)]) == 0
    text = out.read_text(encoding="utf-8")
    assert "time_s" in text
    assert "0.012345" not in text
    assert not list(tmp_path.glob("*.truth.*"))
    assert main(["fly", str(case), "-o", str(out), "--truth"]) == 0
    assert (tmp_path / "log.truth.parquet").exists()


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        ("--maneuver step_decreas", "'step_decrease'"),
        ("--das 20-1", "20/1"),
        ("--das 1/20", "GPS rate"),
        ("--model cubic", "Known"),
        ("--turbulence lite", "'light'"),
        ("--pilot ace", "none, good, busy"),
        ("--aircraft navaho", "navajo"),
        ("--seeds 0", "--seeds"),
        ("--wind-kt -5", "--wind-kt"),
        ("--wind-kt nan", "--wind-kt"),
        ("--wind-from-deg nan", "--wind-from-deg"),
        ("--shard 3/2", "shard"),
        ("--shard x", "shard"),
        ("--keep-logs some", "none, failed, all"),
        ("--time-limit 0", "limit"),
    ],
)
def test_campaign_refuses_wrong_names_and_leaves_nothing(flags, says, tmp_path, capsys):
    right = ["--maneuver", "circle", "--das", "20/1", "--jobs", "1", "--out", str(tmp_path / "out")]
    assert main(["campaign", *right, *flags.split()]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert "Traceback" not in error
    assert list(tmp_path.iterdir()) == []


def test_a_campaign_of_one_flight_says_what_its_page_says(tmp_path, capsys):
    flags = [
        "--maneuver",
        "rapid_decel",
        "--das",
        "20/1",
        "--jobs",
        "1",
        "--out",
        str(tmp_path / "out"),
    ]
    assert main(["campaign", *flags]) == 0
    first, *_, last = capsys.readouterr().out.splitlines()
    (log,) = (tmp_path / "out" / "logs").iterdir()
    answer = short_answer_of(calibrate(read_log(log)), "")
    assert first == f"{answer.correction_sentence} {answer.wind_sentence}"
    assert last == f"open this page: {tmp_path / 'out' / 'report.html'}"


def test_campaign_does_not_replace_a_stranger_folder(tmp_path, capsys):
    (tmp_path / "thesis.txt").write_text("mine")
    flags = ["--maneuver", "rapid_decel", "--das", "20/1", "--jobs", "1", "--out", str(tmp_path)]
    assert main(["campaign", *flags]) == 2
    assert (tmp_path / "thesis.txt").read_text() == "mine"
    assert "choose another --out" in capsys.readouterr().err


def test_help_lists_every_maneuver(capsys):
    with pytest.raises(SystemExit) as stop:
        main(["campaign", "--help"])
    assert stop.value.code == 0
    text = capsys.readouterr().out
    assert all(name in text for name in MANEUVERS)


def test_a_mapping_advises_and_a_flag_decides(log, tmp_path, capsys):
    columns = next(line for line in log.read_text().splitlines() if not line.startswith("#")).split(
        ","
    )
    mapping = tmp_path / "mine.toml"
    for advice, flags, model in (
        ('model = "linear"', [], "linear"),
        ('model = "linear"', ["--model", "bias"], "bias"),
        ('modle = "linear"', [], None),
    ):
        mapping.write_text(
            "\n".join(["[columns]", *(f'{n} = "{n}"' for n in columns), "[calibrate]", advice])
        )
        code = main(["calibrate", str(log), "--mapping", str(mapping), "--json", *flags])
        said = capsys.readouterr()
        assert code == (2 if model is None else 0)
        assert (
            "Did you mean 'model'" in said.err
            if model is None
            else json.loads(said.out)["model"] == model
        )


def test_a_word_for_several_maneuvers_means_the_same_everywhere():
    """`all` is the paper's five, `every` the whole table, for campaigns and plans alike."""
    parse = command_line().parse_args
    for word, flown in (
        ("all", PAPER_MANEUVERS),
        ("every", tuple(MANEUVERS)),
        ("circle,circle", ("circle",)),
    ):
        assert maneuvers_named(word) == flown
        assert plan_request(parse(["plan", "--maneuver", word])).maneuvers == flown
        tasks = [
            *plan_of_names(Case(), word, "20/1", "bias", range(1, 2), CalibrationOptions()).tasks()
        ]
        assert tuple(task.case.maneuver for task in tasks) == flown
    assert maneuvers_named("all,cloverleaf") == (*PAPER_MANEUVERS, "cloverleaf")
    for wrong in ("", " , "):
        with pytest.raises(BadInputError, match="no maneuver is named"):
            maneuvers_named(wrong)


def script(shell, capsys):
    assert main(["completion", shell]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_command_is_completed_with_its_flags(shell, capsys):
    text = script(shell, capsys)
    for command in COMMANDS:
        assert command.name in text
    for flag in ("mapping", "accuracy", "box-nm", "keep-logs"):
        assert f"--{flag}" in text or f"-l {flag} " in text


@pytest.mark.parametrize(
    ("typed", "hint"),
    [
        ("flight.csv", "pitotbench calibrate flight.csv` or `pitotbench open flight.csv"),
        (".", "pitotbench calibrate ."),
        ("wind.toml", "pitotbench campaign wind.toml"),
        ("calibrte", "Did you mean 'calibrate'?"),
    ],
)
def test_what_is_no_command_gets_one(typed, hint, capsys):
    with pytest.raises(SystemExit, match="2"):
        main([typed])
    assert hint in capsys.readouterr().err


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_reads_its_script(shell, capsys, tmp_path):
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    path = tmp_path / "script"
    path.write_text(script(shell, capsys), encoding="utf-8")
    done = subprocess.run([shell, "-n", str(path)], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        (["cal"], {"calibrate"}),
        (["calibrate", "--rep"], {"--report"}),
        (["plan", "--by"], {"--by-hand"}),
        (["calibrate", "fli"], set()),  # a file: left to the shell
    ],
)
def test_bash_offers_what_fits(typed, offered, capsys, tmp_path):
    if shutil.which("bash") is None:
        pytest.skip("bash is not installed")
    path = tmp_path / "script"
    words = " ".join(f'"{word}"' for word in ["pitotbench", *typed])
    asked = f'COMP_WORDS=({words}); COMP_CWORD={len(typed)}; _shtab_pitotbench; printf "%s\\n" "${{COMPREPLY[@]}}"'
    path.write_text(script("bash", capsys) + asked, encoding="utf-8")
    done = subprocess.run(["bash", str(path)], capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) == offered


RATE = 10
TABLE = "───"


@pytest.fixture(scope="module")
def ended_log(tmp_path_factory):
    """Turns of which the fastest stands at the end of the sensor's range; the static pressure never
    changes.
    """
    at = np.array([0.0, 90.0, 150.0, 240.0, 300.0, 390.0])
    time = np.arange(390 * RATE) / RATE
    speed = np.interp(time, at, [100.0, 100.0, 130.0, 130.0, 160.0, 160.0]) * KNOT
    heading = np.interp(time, at, [0.0, 400.0, 400.0, 800.0, 800.0, 1200.0]) * DEGREE
    flown = fixture.fly((speed, heading), RATE, RATE, fixture.Air())
    ended = replace(flown, impact_pressure=np.minimum(flown.impact_pressure, 3500.0))
    return write_log(ended, tmp_path_factory.mktemp("log") / "flight.csv")


SENTENCES = {"calibrate": "Add ", "inspect": "Indicated airspeeds", "fixed-speed": "flight.csv"}


@pytest.mark.parametrize("command", list(SENTENCES))
def test_warnings_stand_between_the_answer_and_its_table(ended_log, capsys, command):
    assert main([command, str(ended_log)]) == 0
    lines = capsys.readouterr().out.splitlines()
    answer = next(i for i, line in enumerate(lines) if SENTENCES[command] in line)
    table = next(i for i, line in enumerate(lines) if TABLE in line)
    first = 3 if command == "calibrate" else 0  # the line of its first doubt
    assert main([command, str(ended_log), "--json"]) == 0
    document = capsys.readouterr().out
    for words in ("never changes", "end of the sensor's range"):
        places = [
            i
            for i, line in enumerate(lines)
            if words in line and (line.startswith("warning: ") or i == first)
        ]
        assert len(places) == 1, lines
        assert answer < places[0]
        # A calibration has the first of its doubts above its table, and others below.
        assert places[0] < table or first
        assert words in " ".join(json.loads(document)["warnings"])
