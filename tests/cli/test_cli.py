"""The command line's contract: what it prints, its exit codes, one clear error, nothing half-written."""

import json

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import BadInputError, CalibrationOptions, Case, read_log, write_log
from pitotbench.bench.campaign_plan import plan_of_names
from pitotbench.calibration import calibrate
from pitotbench.cli.app import command_line, main
from pitotbench.cli.plan import request_of as plan_request
from pitotbench.show.calibration import short_answer_of
from pitotbench.simulation.maneuvers import MANEUVERS, PAPER_MANEUVERS, maneuvers_named

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
    keys = {"model", "parameters", "wind", "curve", "residual_two_sigma_kt", "samples", "converged", "warnings"}
    assert keys <= set(answer)
    assert set(answer["wind"]) == WIND_KEYS
    assert all(set(point) == CURVE_KEYS for point in answer["curve"])
    assert [p["name"] for p in answer["parameters"]] == ["k1", "k2", "k3"]
    middle = answer["curve"][len(answer["curve"]) // 2]
    truth = fixture.true_correction(np.array([middle["indicated_airspeed_kt"]]) * 1852 / 3600)[0] * 3600 / 1852
    assert abs(middle["correction_kt"] - truth) < 2 * middle["two_sigma_kt"]


def test_calibrate_prints_units_and_writes_a_page(log, tmp_path, capsys):
    page = tmp_path / "page.html"
    assert main(["calibrate", str(log), "--model", "quadratic", "--report", str(page)]) == 0
    assert "[kt]" in capsys.readouterr().out
    assert "<svg" in page.read_text(encoding="utf-8")


def test_fixed_speed_of_a_log_and_beside_the_curve(tmp_path, capsys):
    rate = 10
    heading = np.linspace(0.0, 400.0, 90 * rate) * np.pi / 180.0
    speed = np.concatenate([np.full(90 * rate, 55.0), np.linspace(55.0, 75.0, 60 * rate), np.full(90 * rate, 75.0)])
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
    assert main(["fixed-speed", str(name), str(name), "--accuracy", "temperature_k=3", "--json"]) == 0
    one, other = (document["fixed_speed"] for document in json.loads(capsys.readouterr().out))
    assert one == other
    assert all(wide["two_sigma_kt"] > point["two_sigma_kt"] for wide, point in zip(one, points, strict=True))


def test_fixed_speed_wants_a_log_with_legs_or_typed_legs(log, capsys):
    for flags in ("", "--track-deg 1,2,3", "x.csv --track-deg 1", "--ground-speed-kt a --track-deg 1"):
        assert main(["fixed-speed", *flags.split()]) == 2
        assert "--ground-speed-kt" in capsys.readouterr().err
    assert main(["fixed-speed", str(log)]) == 3
    assert "four legs" in capsys.readouterr().err
    # The worked example of four legs.
    assert (
        main(["fixed-speed", "--ground-speed-kt", "178,185,188,184", "--track-deg", "178,82,355,265", "--json"])
        == 0
    )
    answer = json.loads(capsys.readouterr().out)
    assert answer["true_airspeed_kt"] == pytest.approx(183.7267, abs=5e-5)
    assert answer["spread_kt"] == pytest.approx(0.8271, abs=5e-5)


def test_fly_writes_a_log_without_truth(tmp_path, capsys):
    case = tmp_path / "case.toml"
    case.write_text(
        'maneuver = "rapid_decel"\nturbulence = "none"\n[pressure_error]\nparameters = [0.012345, 0.0, 0.0]\n'
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
    flags = ["--maneuver", "rapid_decel", "--das", "20/1", "--jobs", "1", "--out", str(tmp_path / "out")]
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
    columns = next(line for line in log.read_text().splitlines() if not line.startswith("#")).split(",")
    mapping = tmp_path / "mine.toml"
    for advice, flags, model in (
        ('model = "linear"', [], "linear"),
        ('model = "linear"', ["--model", "bias"], "bias"),
        ('modle = "linear"', [], None),
    ):
        mapping.write_text("\n".join(["[columns]", *(f'{n} = "{n}"' for n in columns), "[calibrate]", advice]))
        code = main(["calibrate", str(log), "--mapping", str(mapping), "--json", *flags])
        said = capsys.readouterr()
        assert code == (2 if model is None else 0)
        assert "Did you mean 'model'" in said.err if model is None else json.loads(said.out)["model"] == model


def test_a_word_for_several_maneuvers_means_the_same_everywhere():
    """`all` is the paper's five, `every` the whole table, for campaigns and plans alike."""
    parse = command_line().parse_args
    for word, flown in (("all", PAPER_MANEUVERS), ("every", tuple(MANEUVERS)), ("circle,circle", ("circle",))):
        assert maneuvers_named(word) == flown
        assert plan_request(parse(["plan", "--maneuver", word])).maneuvers == flown
        tasks = [*plan_of_names(Case(), word, "20/1", "bias", range(1, 2), CalibrationOptions()).tasks()]
        assert tuple(task.case.maneuver for task in tasks) == flown
    assert maneuvers_named("all,cloverleaf") == (*PAPER_MANEUVERS, "cloverleaf")
    for wrong in ("", " , "):
        with pytest.raises(BadInputError, match="no maneuver is named"):
            maneuvers_named(wrong)
