"""The judge of the independent generator: what is held against the truth, the file that goes on, the
table of one build and of two.
"""

import json
from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from pitotbench.cli.app import main as pitotbench_command
from pitotbench.records import BadInputError
from pitotbench.records.log import Caution
from pitotlab.__main__ import main
from pitotlab.outside import judge
from pitotlab.outside.judge import JudgedRow, logs_of, table
from pitotlab.outside.moving_air import CELLS
from pitotlab.outside.physics import FOOT, KNOT
from pitotlab.outside.written import write_flight, write_set
from pitotlab.sets import read_rows, wilson

TRUTH = {
    "indicated_airspeed_kt": [100.0, 160.0],
    "correction_kt": [1.0, 3.0],
    "position_error_ft": [20.0, 50.0],
    "mean_wind_kt": [5.0, -2.0],
}


def _row(seed, kind="base", **entries):
    usual = {"inside": 1.0, "two_sigma_kt": 0.6, "rms_kt": 0.3, "warned": 0.0, "headline": 0.0}
    zs = {f"z{number}": 0.5 for number in range(1, 6)}
    return JudgedRow(kind, seed, "{}", "circle", 20.0, "answered", **(usual | zs | entries))


def _answer(error, bound, wind, warnings=()):
    airspeed = np.array([90.0, 100.0, 120.0, 140.0, 160.0, 170.0])
    true, feet = (
        np.interp(airspeed, TRUTH["indicated_airspeed_kt"], TRUTH[name])
        for name in ("correction_kt", "position_error_ft")
    )
    curve = SimpleNamespace(
        indicated_airspeed=airspeed * KNOT,
        correction=(true + error) * KNOT,
        two_sigma=np.full(6, bound * KNOT),
        simultaneous_two_sigma=np.full(6, 2.0 * bound * KNOT),
        altitude_correction=(feet + 20.0 * error) * FOOT,
        altitude_two_sigma=np.full(6, 5.0 * FOOT),
    )
    north, east = (SimpleNamespace(value=v * KNOT, two_sigma=0.5 * KNOT) for v in wind)
    said = {
        "warnings": [Caution(words, "prior", "temperature_k") for words in warnings],
        "disagreements": (),
        "usable": True,
    }
    return SimpleNamespace(curve=curve, wind=SimpleNamespace(north=north, east=east), **said)


def test_an_answer_is_held_against_the_truth_where_it_was_flown():
    error = np.array([9.0, 0.1, 0.2, -0.3, 0.6, 9.0])  # 90 and 170 kt were not flown
    found = judge.errors_of(_answer(error, 0.4, (5.4, -2.6), ("it is warm",)), TRUTH)
    assert found["inside"] == 0.75
    assert found["whole"] == 1.0
    assert found["inside_ft"] == 0.5
    assert found["two_sigma_kt"] == pytest.approx(0.4)
    assert found["rms_kt"] == pytest.approx(np.sqrt(np.mean(error[1:5] ** 2)))
    assert found["wind_inside"] == 0.5
    assert found["z3"] == pytest.approx(np.mean([0.2, -0.3]) / 0.2)  # 130 kt
    assert found["worst"] == pytest.approx(1.5)
    said = [found[name] for name in ("warned", "headline", "codes", "says")]
    assert said == [1.0, 0.0, "prior temperature_k", "it is warm"]
    without = _answer(error, 0.4, (0.0, 0.0))
    without.wind = without.curve.altitude_correction = None
    held = judge.errors_of(without, TRUTH)
    assert np.isnan(held["wind_inside"])
    assert np.isnan(held["inside_ft"])


def test_the_judge_asks_for_what_the_command_does_without_a_flag(tmp_path, capsys):
    # GPS 2 s late in calm air: the command checks it, and warns
    beside = write_flight(replace(CELLS["calm"], gps_late=2.0), 2, tmp_path)
    log = beside.with_name("2.csv")
    assert pitotbench_command(["calibrate", str(log), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    options, _ = judge.options_known(judge.COMMAND_DEFAULTS)
    found = judge.calibrate(judge.read_log(log), options)
    assert printed["warnings"] == list(found.warnings) != []
    for name in ("correction_kt", "two_sigma_kt"):
        told = [point[name] for point in printed["curve"]]
        np.testing.assert_allclose(told, getattr(found.curve, name), atol=1e-6)


def test_a_choice_that_a_build_does_not_know_is_left_out_with_a_note(capsys):
    options, words = judge.options_known(
        {"wind": "checked", "tide": "low", "error_location": "wing", "recovery_factor": 0.9}
    )
    assert json.loads(words) == {"recovery_factor": 0.9, "wind": "checked"}
    assert options.recovery_factor == 0.9
    noted = capsys.readouterr().err
    assert "tide='low'" in noted
    assert "error_location='wing'" in noted


def test_a_run_that_was_ended_goes_on_and_other_choices_are_other_rows(tmp_path, monkeypatch):
    asked = []

    def judge_log(path, truth, options):
        asked.append((truth["set"], truth["seed"], options.model))
        return {"outcome": "refused", "says": "too\nshort"}

    monkeypatch.setattr(judge, "judge_log", judge_log)
    out, smooth = tmp_path / "rows.csv", judge.COMMAND_DEFAULTS["model"]
    judge.judge(logs_of(["calm"], range(1, 3)), out, {})
    with out.open("ab") as file:
        file.write(b"calm,3,{}")  # a run that was ended while it wrote
    write_set("calm", [2, 3], tmp_path)
    again = judge.judge(logs_of([str(tmp_path)], ()), out, {})
    assert asked == [("calm", seed, smooth) for seed in (1, 2, 3)]
    assert [row.seed for row in again] == [2, 3]
    assert (again[0].set, again[0].says) == ("calm", "too short")
    judge.judge(logs_of(["calm"], [1]), out, {"model": "linear"})
    assert asked[-1] == ("calm", 1, "linear")
    assert [row.seed for row in read_rows(out, JudgedRow)] == [1, 2, 3, 1]
    with pytest.raises(BadInputError, match="outside write"):
        logs_of([str(tmp_path / "nowhere")], ())


def test_a_set_and_its_written_logs_are_judged_alike_from_the_command_to_the_row(tmp_path, capsys):
    write_set("calm", [1], tmp_path)
    rows = []
    for where in (str(tmp_path), "calm"):
        out = tmp_path / f"{len(rows)}.csv"
        assert main(["outside", "judge", where, "--seeds", "1:2", "--out", str(out)]) == 0
        rows += read_rows(out, JudgedRow)
    assert main(["outside", "compare", *(str(tmp_path / f"{n}.csv") for n in (0, 1))]) == 0
    assert "2/1" in capsys.readouterr().out
    one, other = (replace(row, cpu_s=0.0, inside_ft=0.0) for row in rows)  # no height in the answer
    assert one == other
    assert (rows[0].set, rows[0].outcome, rows[0].usable) == ("calm", "answered", 1.0)
    assert 0.0 < rows[0].rms_kt < 1.0
    assert rows[0].cpu_s > 0.0
    numbers = [getattr(rows[0], field.name) for field in fields(JudgedRow) if field.type is float]
    assert np.isfinite(numbers).sum() >= len(numbers) - 1


def test_a_crash_is_a_row_with_its_words(monkeypatch):
    def fall(log, options):
        raise ZeroDivisionError("no samples")

    monkeypatch.setattr(judge, "calibrate", fall)
    row = judge.judged({}, judge.Asked(CELLS["calm"], 1))
    assert (row.outcome, row.says) == ("crashed", "ZeroDivisionError: no samples")


@pytest.mark.parametrize(
    "seeds", ["50000:50001", "49999:50001", "599999:600004", "5", "9:9", "b:9"]
)
@pytest.mark.parametrize("command", ["judge", "write"])
def test_seeds_are_either_of_development_or_scored(command, seeds, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["outside", command, "base", "--seeds", seeds, "--out", str(tmp_path / "rows")])
    assert ended.value.code == 2
    assert "seeds" in capsys.readouterr().err


def test_the_interval_of_a_count_is_that_of_wilson():
    """Agresti and Coull (1998): 49 to 94 % for 8 of 10."""
    assert wilson(8, 10) == pytest.approx((0.490, 0.943), abs=0.001)
    assert wilson(0, 0) == (0.0, 1.0)


def _lines(*files):
    aligned, *below = table(*files)
    heads, *lines = [line.split("  ") for line in aligned.splitlines()]
    heads, *lines = [[each.strip() for each in line if each.strip()] for line in (heads, *lines)]
    return {line[0]: dict(zip(heads, line, strict=True)) for line in lines}, below


def test_two_builds_stand_side_by_side_on_the_logs_that_both_have():
    first = [
        _row(1),
        _row(2, inside=0.4),  # wrong, in silence
        _row(3, inside=0.2, warned=1.0, says="temperature, or a leak"),
        _row(1, kind="probe_5k", inside=0.0),
        _row(9),  # the second has not judged it
    ]
    other = {"two_sigma_kt": 1.2, "headline": 1.0, "codes": "height, prior temperature_k"}
    second = [
        _row(1, two_sigma_kt=0.3),
        _row(2, two_sigma_kt=0.3),
        replace(_row(3), outcome="refused"),
        _row(1, kind="probe_5k", **other),
    ]
    lines, below = _lines(first, second)
    base = lines["base"]
    assert (base["n 1"], base["n 2"]) == ("3", "2")
    assert (base["wrong 1"], base["silent 1"], base["wrong 2"]) == ("2", "1", "0")
    assert base["inside % 1"] == "53.3"
    assert base["2/1"] == "0.50"  # of the two that both answer
    assert (lines["all"]["wrong 1"], lines["without probes"]["wrong 1"]) == ("3", "2")
    assert lines["probe_5k"]["headline 2"] == "1"
    assert below[0].startswith("base, 1: wrong 2 of 3 (20.8 to 93.9 %)")
    assert "1 refused, 0 crashed" in below[1]
    assert lines["circle"]["n 1"] == "3"  # no probes
    said = next(line for line in below if line.startswith("probe_5k, 2"))
    assert said.endswith("said: height 1, prior temperature_k 1")
    with pytest.raises(BadInputError, match="twice"):
        table([_row(1), _row(1)], second)


def test_one_build_has_a_table_with_the_standard_error_of_what_is_inside():
    lines, below = _lines([_row(1), _row(2, inside=0.8), _row(3, inside=0.9)])
    assert (lines["base"]["n 1"], lines["base"]["inside % 1"]) == ("3", "90.0")
    assert "inside 90.0 ± 5.8 %" in below[0]
    lines, below = _lines([replace(_row(1, kind="late"), outcome="refused")])
    assert (lines["late"]["n 1"], lines["late"]["inside % 1"]) == ("0", "–")


def test_a_flight_is_wrong_where_half_is_outside_or_a_point_is_off_by_two_bounds():
    assert judge.is_wrong(_row(1, inside=0.49))
    assert not judge.is_wrong(_row(1, inside=0.5, worst=1.9))
    assert judge.is_wrong(_row(1, inside=0.9, worst=2.1))


def test_a_finding_that_names_another_cause_does_not_name_a_leak():
    told = {"inside": 0.3, "warned": 1.0}
    leak = _row(1, kind="leak", says="The pitot line leaks.", **told)
    other = _row(2, kind="leak", says="the wind changed", **told)
    silent = _row(3, kind="leak", inside=0.3)
    assert [judge.is_named(row) for row in (leak, other, silent)] == [True, False, False]
    assert float(judge.FIGURES["in or named %"]([leak, other, silent])) == pytest.approx(53.3)
    # a wave has no name of its own: any word tells of it
    assert judge.is_named(_row(4, kind="wave", says="the wind changed", **told))


def test_ranks_of_honest_bounds_are_uniform_and_those_of_bounds_too_small_are_not():
    dice = np.random.default_rng(1)
    for spread, passes in ((1.0, True), (2.0, False)):
        z = spread * dice.standard_normal((200, 5))
        rows = [
            _row(seed, **{f"z{place + 1}": value for place, value in enumerate(line)})
            for seed, line in enumerate(z)
        ]
        said = judge.ranks_of(rows)
        p = float(said.rpartition("p = ")[2].rstrip(")"))
        assert (p > 0.01) == passes
        rms = float(judge.FIGURES["rms z"](rows))
        assert rms == pytest.approx(np.sqrt(np.mean(z**2)), abs=0.006)
        one = z[np.arange(200), np.arange(200) % 5]
        assert f"ranks {int(np.sum(norm.cdf(one) < 0.1))} " in said


def test_the_cells_of_the_page_are_flown_as_themselves():
    """A kind may bear the name of a cell and fly other maneuvers."""
    asked = logs_of(["cells"], [6_700_000])
    assert [each.cell for each in asked] == [*CELLS.values()]
