"""Two builds on the same logs: what is held against the truth, the file that goes on, the table."""

import json
from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from pitotbench.records import BadInputError
from pitotbench.records.log import Caution
from pitotlab.__main__ import main
from pitotlab.outside import builds
from pitotlab.outside.builds import BuildRow
from pitotlab.outside.judge import read_rows
from pitotlab.outside.physics import KNOT
from pitotlab.outside.written import write_set

TRUTH = {
    "indicated_airspeed_kt": [100.0, 160.0],
    "correction_kt": [1.0, 3.0],
    "mean_wind_kt": [5.0, -2.0],
}


def _row(seed, kind="base", **entries):
    usual = {"inside": 1.0, "two_sigma_kt": 0.6, "rms_kt": 0.3, "warned": 0.0, "headline": 0.0}
    zs = {f"z{number}": 0.5 for number in range(1, 6)}
    return BuildRow(kind, seed, "{}", "circle", 20.0, "answered", **(usual | zs | entries))


def _answer(error, bound, wind, warnings=()):
    airspeed = np.array([90.0, 100.0, 120.0, 140.0, 160.0, 170.0])
    true = np.interp(airspeed, TRUTH["indicated_airspeed_kt"], TRUTH["correction_kt"])
    curve = SimpleNamespace(
        indicated_airspeed=airspeed * KNOT,
        correction=(true + error) * KNOT,
        two_sigma=np.full(6, bound * KNOT),
    )
    north, east = (SimpleNamespace(value=v * KNOT, two_sigma=0.5 * KNOT) for v in wind)
    found = SimpleNamespace(north=north, east=east)
    said = {
        "warnings": [Caution(words, "prior", "temperature_k") for words in warnings],
        "disagreements": (),
        "usable": True,
    }
    return SimpleNamespace(curve=curve, wind=found, **said)


def test_an_answer_is_held_against_the_truth_where_it_was_flown():
    error = np.array([9.0, 0.1, 0.2, -0.3, 0.6, 9.0])  # 90 and 170 kt were not flown
    errors_of = builds.errors_of(_answer(error, 0.4, (5.4, -2.6), ("it is warm",)), TRUTH)
    assert errors_of["inside"] == 0.75
    assert errors_of["two_sigma_kt"] == pytest.approx(0.4)
    assert errors_of["rms_kt"] == pytest.approx(np.sqrt(np.mean(error[1:5] ** 2)))
    assert errors_of["wind_inside"] == 0.5
    assert errors_of["z3"] == pytest.approx(np.mean([0.2, -0.3]) / 0.2)  # 130 kt
    assert errors_of["worst"] == pytest.approx(1.5)
    said = [errors_of[name] for name in ("warned", "headline", "codes", "says")]
    assert said == [1.0, 0.0, "prior temperature_k", "it is warm"]
    no_wind = _answer(error, 0.4, (0.0, 0.0))
    no_wind.wind = None
    assert np.isnan(builds.errors_of(no_wind, TRUTH)["wind_inside"])


def test_a_choice_that_a_build_does_not_know_is_left_out_with_a_note(capsys):
    options, words = builds.options_known(
        {"wind": "checked", "tide": "low", "error_location": "wing", "recovery_factor": 0.9}
    )
    assert json.loads(words) == {"recovery_factor": 0.9, "wind": "checked"}
    assert options.recovery_factor == 0.9
    noted = capsys.readouterr().err
    assert "tide='low'" in noted
    assert "error_location='wing'" in noted


def test_a_run_that_was_ended_goes_on_and_other_choices_are_other_rows(tmp_path, monkeypatch):
    for seed in (1, 2):
        path = tmp_path / "base" / f"{seed}.truth.json"
        path.parent.mkdir(exist_ok=True)
        named = {"set": "base", "seed": seed, "maneuver": "circle", "gps_hz": 1.0}
        path.write_text(json.dumps({**TRUTH, **named, "calibrate": {"model": "auto"}}))
    judged = []

    def judge_log(path, truth, options):
        judged.append((path.name, options.model))
        return {"outcome": "refused", "says": "too\nshort"}

    monkeypatch.setattr(builds, "judge_log", judge_log)
    out = tmp_path / "rows.csv"
    builds.judge_folders([tmp_path], out, {})
    assert judged == [("1.csv", "auto"), ("1.csv", "auto"), ("2.csv", "auto")]  # the first is warm
    with out.open("ab") as file:
        file.write(b"base,3,{}")  # a run that was ended while it wrote
    judged.clear()
    builds.judge_folders([tmp_path], out, {})
    assert judged == []
    builds.judge_folders([tmp_path], out, {"model": "linear"})
    assert {model for _, model in judged} == {"linear"}
    rows = read_rows(out, BuildRow)
    assert [row.seed for row in rows] == [1, 2, 1, 2]
    assert rows[0].says == "too short"
    with pytest.raises(BadInputError, match="outside write"):
        builds.judge_folders([tmp_path / "nowhere"], out, {})


def test_a_log_is_judged_from_file_to_row(tmp_path):
    write_set("calm", [1], tmp_path)
    out = tmp_path / "rows.csv"
    assert main(["outside", "judge", str(tmp_path), "--out", str(out)]) == 0
    (row,) = read_rows(out, BuildRow)
    assert (row.set, row.outcome, row.usable) == ("calm", "answered", 1.0)
    assert 0.0 < row.rms_kt < 1.0
    assert row.cpu_s > 0.0
    numbers = [getattr(row, field.name) for field in fields(row) if field.type is float]
    assert np.all(np.isfinite(numbers))


def test_the_interval_of_a_count_is_that_of_wilson():
    """Agresti and Coull (1998): 49 to 94 % for 8 of 10."""
    assert builds.wilson(8, 10) == pytest.approx((49.0, 94.3), abs=0.1)
    assert np.all(np.isnan(builds.wilson(0, 0)))


def test_two_builds_stand_side_by_side_on_the_logs_that_both_have():
    first = [
        _row(1),
        _row(2, inside=0.4),  # wrong, in silence
        _row(3, inside=0.2, warned=1.0, says="temperature, or a leak"),
        _row(1, kind="probe_5k", inside=0.0),
        _row(9),  # the second has not judged it
    ]
    second = [
        _row(1, two_sigma_kt=0.3),
        _row(2, two_sigma_kt=0.3),
        replace(_row(3), outcome="refused"),
        _row(
            1, kind="probe_5k", two_sigma_kt=1.2, headline=1.0, codes="height, prior temperature_k"
        ),
    ]
    lines, below = builds.compared(first, second)
    table = {line[0]: dict(zip(lines[0], line, strict=True)) for line in lines[1:]}
    base = table["base"]
    assert (base["n 1"], base["n 2"]) == ("3", "2")
    assert (base["wrong 1"], base["silent 1"], base["wrong 2"]) == ("2", "1", "0")
    assert base["inside % 1"] == "53.3"
    assert base["2/1"] == "0.50"  # of the two that both answer
    assert (table["all"]["wrong 1"], table["without probes"]["wrong 1"]) == ("3", "2")
    assert table["probe_5k"]["headline 2"] == "1"
    assert below[0].startswith("base, 1: wrong 2 of 3 (20.8 to 93.9 %)")
    assert table["circle"]["n 1"] == "3"  # no probes
    said = next(line for line in below if line.startswith("probe_5k, 2"))
    assert said.endswith("said: height 1, prior temperature_k 1")
    with pytest.raises(BadInputError, match="twice"):
        builds.compared([_row(1), _row(1)], second)


def test_a_flight_is_wrong_where_half_is_outside_or_a_point_is_off_by_two_bounds():
    assert builds.is_wrong(_row(1, inside=0.49))
    assert not builds.is_wrong(_row(1, inside=0.5, worst=1.9))
    assert builds.is_wrong(_row(1, inside=0.9, worst=2.1))


def test_a_finding_that_names_another_cause_does_not_name_a_leak():
    told = {"inside": 0.3, "warned": 1.0}
    leak = _row(1, kind="leak", says="The pitot line leaks.", **told)
    other = _row(2, kind="leak", says="the wind changed", **told)
    silent = _row(3, kind="leak", inside=0.3)
    assert [builds.is_named(row) for row in (leak, other, silent)] == [True, False, False]
    assert float(builds.FIGURES["in or named %"]([leak, other, silent])) == pytest.approx(53.3)
    # a wave has no name of its own: any word tells of it
    assert builds.is_named(_row(4, kind="wave", says="the wind changed", **told))


def test_ranks_of_honest_bounds_are_uniform_and_those_of_bounds_too_small_are_not():
    dice = np.random.default_rng(1)
    for spread, passes in ((1.0, True), (2.0, False)):
        z = spread * dice.standard_normal((200, 5))
        rows = [
            _row(seed, **{f"z{place + 1}": value for place, value in enumerate(line)})
            for seed, line in enumerate(z)
        ]
        said = builds.ranks_of(rows)
        p = float(said.rpartition("p = ")[2].rstrip(")"))
        assert (p > 0.01) == passes
        rms = float(builds.FIGURES["rms z"](rows))
        assert rms == pytest.approx(np.sqrt(np.mean(z**2)), abs=0.006)
        one = z[np.arange(200), np.arange(200) % 5]
        lowest = int(np.sum(norm.cdf(one) < 0.1))
        assert f"ranks {lowest} " in said


@pytest.mark.parametrize("seeds", ["49999:50001", "5", "b:9"])
def test_sets_are_written_with_seeds_of_development_or_scored(seeds, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["outside", "write", "base", "--seeds", seeds, "--out", str(tmp_path)])
    assert ended.value.code == 2
    assert "seeds" in capsys.readouterr().err
