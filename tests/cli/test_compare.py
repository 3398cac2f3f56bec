"""`compare`: two curves, their difference with its bound, one sentence."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import BadInputError, write_log
from pitotbench.cli.app import main
from pitotbench.pressure_error.models import PressureErrorCurve
from pitotbench.records.calibration import ErrorCurve
from pitotbench.show.curve_difference import compare_curves, difference_sentence
from pitotbench.units import KNOT

# Several voices of one answer are looked at: each log is fitted once.
pytestmark = pytest.mark.usefixtures("one_fit_of_each_log")


def curve(low_kt, high_kt, correction_kt, two_sigma_kt=0.3):
    speed = np.arange(low_kt, high_kt + 1.0, 5.0)
    value = np.broadcast_to(
        correction_kt(speed) if callable(correction_kt) else correction_kt, speed.shape
    )
    bound, zero = np.full(len(speed), two_sigma_kt) * KNOT, np.zeros(len(speed))
    return ErrorCurve(speed * KNOT, value * KNOT, bound, bound, bound, zero, zero)


def test_the_difference_is_that_of_the_corrections_and_its_bound_adds_as_squares():
    one, other = curve(60, 160, 1.0, 0.3), curve(80, 180, lambda v: v / 100.0, 0.4)
    found = compare_curves("old", one, "new", other)
    speed = found.indicated_airspeed / KNOT
    assert (speed[0], speed[-1]) == pytest.approx((80.0, 160.0))
    np.testing.assert_allclose(found.difference / KNOT, speed / 100.0 - 1.0, atol=1e-12)
    np.testing.assert_allclose(found.two_sigma / KNOT, 0.5)
    back = compare_curves("new", other, "old", one)
    np.testing.assert_allclose(back.difference, -found.difference)


def test_the_sentence_says_where_it_reads_lower_and_where_no_difference_shows():
    other = curve(60, 160, lambda v: np.interp(v, [60.0, 100.0, 140.0], [1.0, 1.8, 0.0]))
    found = compare_curves("the old port", curve(60, 160, 0.0), "the new port", other)
    assert found.differs
    said = (
        "the new port reads 1.8 ± 0.4 kt lower at 100 KIAS than the old port; no difference "
        "above 130 (± is 2σ)."
    )
    assert difference_sentence(found) == said
    found = compare_curves(
        "A", curve(60, 160, 0.0), "B", curve(60, 160, lambda v: (110.0 - v) / 50.0 * 1.5)
    )
    said = difference_sentence(found)
    assert "lower at 60 KIAS" in said
    assert "higher at 160 KIAS" in said
    same = compare_curves("A", curve(60, 160, 0.2), "B", curve(60, 160, 0.0))
    assert not same.differs
    assert "no difference shows" in difference_sentence(same)
    with pytest.raises(BadInputError, match="60 to 90 KIAS and 100 to 160 KIAS"):
        compare_curves("A", curve(60, 90, 0.0), "B", curve(100, 160, 0.0))


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """Two flights of one airplane: the second one's static port errs otherwise by a known amount."""
    folder = tmp_path_factory.mktemp("logs")
    worse = PressureErrorCurve(
        fixture.TRUTH.model, (-0.09, 0.01, 0.14), fixture.TRUTH.reference_pressure
    )
    for name, truth, seed in (("old", fixture.TRUTH, 1), ("new", worse, 2)):
        write_log(
            fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air(), seed, truth),
            folder / f"{name}.csv",
        )
    return folder, worse


def test_two_logs_and_their_two_calibrations_give_one_answer_that_holds_the_truth(
    logs, capsys, tmp_path
):
    folder, worse = logs
    for name in ("old", "new"):
        assert main(["calibrate", str(folder / f"{name}.csv"), "--json"]) == 0
        (tmp_path / f"{name}.json").write_text(capsys.readouterr().out, encoding="utf-8")
    answers = []
    for place, suffix in ((folder, "csv"), (tmp_path, "json")):
        assert (
            main(["compare", str(place / f"old.{suffix}"), str(place / f"new.{suffix}"), "--json"])
            == 0
        )
        answers.append(json.loads(capsys.readouterr().out))
    for one, other in zip(answers[0].pop("curve"), answers[1]["curve"], strict=True):
        assert one == pytest.approx(other, abs=1e-6)
    assert answers[0] == {key: value for key, value in answers[1].items() if key != "curve"}
    assert answers[1]["differs"]
    assert set(answers[1]) == {
        "schema",
        "first",
        "second",
        "curve",
        "differs",
        "summary",
    }
    rows = answers[1]["curve"]
    assert set(rows[0]) == {"indicated_airspeed_kt", "difference_kt", "two_sigma_kt"}
    speed = np.array([row["indicated_airspeed_kt"] for row in rows]) * KNOT
    true = (fixture.true_correction(speed, worse) - fixture.true_correction(speed)) / KNOT
    found, bound = (
        np.array([row[key] for row in rows]) for key in ("difference_kt", "two_sigma_kt")
    )
    assert np.all(np.abs(found - true) < 2.0 * bound)


def test_a_calibration_held_against_itself_does_not_differ(logs, capsys, tmp_path):
    folder, _ = logs
    page = tmp_path / "page.html"
    flags = ["compare", str(folder / "old.csv"), str(folder / "old.csv"), "--report", str(page)]
    assert main(flags) == 0
    assert "reads the same" in capsys.readouterr().out
    assert "<svg" in page.read_text(encoding="utf-8")


def test_what_is_no_pair_is_refused(logs, capsys, tmp_path):
    folder, _ = logs
    log, other = str(folder / "old.csv"), tmp_path / "other.json"
    other.write_text('{"curve": 3}', encoding="utf-8")
    for first, second, says in (
        (log, str(other), "give two alike"),
        (
            str(other),
            str(other),
            "not a calibration; write one with: pitotbench calibrate LOG --json",
        ),
        (str(tmp_path / "none.json"), str(other), "cannot be read"),
    ):
        assert main(["compare", first, second]) == 2
        assert says in capsys.readouterr().err
    several = [{"curve": [1]}, {"curve": [2]}]
    other.write_text(json.dumps(several), encoding="utf-8")
    assert main(["compare", str(other), str(other)]) == 2
    assert "several curves" in capsys.readouterr().err


def test_the_2sigma_of_a_difference_covers_no_difference_of_equal_curves():
    """Twenty pairs with independent errors of the stated size: the band holds all airspeeds in
    nearly all.
    """
    rng = np.random.default_rng(5)
    quiet = 0
    for _ in range(20):
        shift = rng.standard_normal(2) * 0.15
        one, other = (
            replace(curve(60, 160, s), simultaneous_two_sigma=curve(60, 160, 0.0).two_sigma)
            for s in shift
        )
        quiet += not compare_curves("A", one, "B", other).differs
    assert quiet >= 15  # 19 are meant; fewer than 15 happen once in 10,000
