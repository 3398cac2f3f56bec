"""The judge's file, its table and its choices."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

from pitotbench.cli.app import main as pitotbench_command
from pitotbench.records.calibration import ErrorCurve
from pitotlab.__main__ import main
from pitotlab.outside import judge
from pitotlab.outside.generator import generate, write_csv
from pitotlab.outside.moving_air import CELLS
from pitotlab.outside.physics import FOOT


def _row(seed, cell="base", **entries):
    speeds = {"two_sigma_kt": 0.6, "rms_error_kt": 0.3, "oracle_two_sigma_kt": 0.5}
    usual = {"maneuver": "circle", "outcome": "answered", "gps_hz": 20.0}
    shares = {"curve_coverage": 1.0, "coverage_ft": 0.5, "warned": 0.0}
    return judge.Row(cell=cell, seed=seed, **(usual | shares | speeds | entries))


def test_the_judge_asks_for_what_the_command_does_without_a_flag(tmp_path, capsys):
    # GPS 2 s late in calm air: the command checks it, and warns
    flight = generate(replace(CELLS["calm"], gps_late=2.0), "circle", 2)
    write_csv(flight.columns, tmp_path / "log.csv")
    assert pitotbench_command(["calibrate", str(tmp_path / "log.csv"), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    curve = printed["curve"]
    found = judge.calibrate(judge.read_log(tmp_path / "log.csv"), judge.usual_options())
    assert printed["warnings"] == list(found.warnings) != []
    for name in ("correction_kt", "two_sigma_kt"):
        told = [point[name] for point in curve]
        np.testing.assert_allclose(told, getattr(found.curve, name), atol=1e-6)


def test_a_second_run_flies_only_what_is_missing(tmp_path, monkeypatch):
    flown = []

    def fly(cell, seed):
        flown.append((cell, seed))
        return _row(seed, cell)

    monkeypatch.setattr(judge, "judge", fly)
    out = tmp_path / "rows.csv"
    first = judge.judge_all(["base"], range(1, 3), 1, out)
    with out.open("ab") as file:
        file.write(b"base,3,cir")  # a run that was ended while it wrote
    again = judge.judge_all(["base", "calm"], range(1, 4), 1, out)
    assert flown == [("base", 1), ("base", 2), ("base", 3), ("calm", 1), ("calm", 2), ("calm", 3)]
    np.testing.assert_equal([asdict(row) for row in again[:2]], [asdict(row) for row in first])
    assert [(row.cell, row.seed) for row in judge.read_rows(out, judge.Row)] == flown


@pytest.mark.parametrize(
    ("seed", "flights"), [(50_000, 1), (49_999, 2), (599_999, 5), (-1, 3), (1, 0)]
)
def test_seeds_are_either_of_development_or_scored(seed, flights, tmp_path, capsys):
    words = f"outside --seed {seed} --flights {flights} --out {tmp_path}/rows.csv"
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    assert ended.value.code == 2
    assert "600000" in capsys.readouterr().err


def test_a_line_of_the_table_says_coverage_its_standard_error_and_the_ratio_to_the_oracle():
    rows = [
        _row(1, curve_coverage=1.0, warned=1.0),
        _row(2, curve_coverage=0.8, two_sigma_kt=0.4, coverage_ft=float("nan")),
        _row(3, curve_coverage=0.9, maneuver="rapid_decel"),
        _row(4, outcome="refused", curve_coverage=float("nan"), two_sigma_kt=float("nan")),
    ]
    line = judge.line_of([asdict(row) for row in rows])
    assert (line["n"], line["refused"], line["curve %"], line["±"]) == ("3", "1", "90.0", "5.8")
    assert line["/oracle"] == "1.07"  # mean of 1.2, 0.8, 1.2
    assert line["2σ/2rms"] == "0.89"  # 0.5333 / 0.6
    assert line["warned %"] == "33"
    assert (line["ft %"], line["ft given"]) == ("50.0", "2")
    assert line["by maneuver %"] == "rapid 90, circle 90"


def test_a_cell_in_which_all_is_refused_has_a_line_of_dashes():
    line = judge.line_of([asdict(judge.Row("late", 1, "circle", 1.0, "refused"))])
    assert (line["n"], line["refused"], line["curve %"], line["/oracle"]) == ("0", "1", "–", "–")


def test_a_crash_is_a_row_with_its_words(monkeypatch):
    def fall(log, options):
        raise ZeroDivisionError("no samples")

    monkeypatch.setattr(judge, "calibrate", fall)
    row = judge.judge("calm", 1)
    assert (row.outcome, row.says) == ("crashed", "ZeroDivisionError: no samples")


def test_the_position_error_is_held_against_the_truth_of_the_generator():
    """A right curve has no error in feet; one 20 ft off is outside a bound of 10 ft."""
    flight = generate(CELLS["calm"], "circle", 1)
    truth, exact = flight.truth, np.ones(len(flight.truth.indicated_airspeed))
    for off, inside in ((0.0, 1.0), (20.0, 0.0)):
        curve = ErrorCurve(
            *(truth.indicated_airspeed, *[exact] * 6),
            altitude_correction=(truth.position_error + off) * FOOT,
            altitude_two_sigma=10.0 * FOOT * exact,
        )
        held = judge._position_error_of(curve, flight, exact > 0.0)
        assert held["coverage_ft"] == inside
        assert held["rms_error_ft"] == pytest.approx(off, abs=1e-9)
