"""Python takes what a user has in the hand: a path, a table, a log, a list; and writes what the command writes."""

import csv

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

import pitotbench
from pitotbench import BadInputError, CalibrationOptions, calibrate, reconcile, write_log


@pytest.fixture(scope="module")
def log():
    return fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air())


@pytest.fixture(scope="module")
def answer(log):
    return calibrate(log, model="quadratic")


def test_a_path_a_table_and_a_log_have_one_answer(log, answer, tmp_path):
    """The table has no header, and so not its accuracies: they are stated as a keyword."""
    exact = {"model": "quadratic", "accuracies": fixture.EXACT, "error_location": "impact"}
    of_log = calibrate(log, **exact)
    for each in (str(write_log(log, tmp_path / "a.parquet")), tmp_path / "a.parquet", log.to_frame()):
        found = calibrate(each, **exact)
        np.testing.assert_allclose(found.curve.correction, of_log.curve.correction, atol=1e-4)
    np.testing.assert_allclose(answer.curve.correction, of_log.curve.correction, atol=1e-6)


def test_a_list_has_one_curve_and_a_wind_each(log, tmp_path):
    path = write_log(fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air(), seed=2), tmp_path / "b.csv")
    one, other = calibrate([log, path])
    np.testing.assert_allclose(one.curve.correction, other.curve.correction)
    assert one.wind.north.value != other.wind.north.value


@pytest.mark.parametrize("given", [3, None, {"a": 1}, [3], []])
def test_another_kind_is_refused_in_one_sentence(given):
    for function in (calibrate, reconcile):
        with pytest.raises(BadInputError, match=r"takes a path, a DataFrame, a log or a list|at least one log"):
            function(given)


def test_wrong_options_get_the_sentence_of_the_command(log):
    with pytest.raises(BadInputError, match="modle"):
        calibrate(log, modle="quadratic")
    with pytest.raises(BadInputError, match="either options or keywords"):
        calibrate(log, CalibrationOptions(), model="quadratic")
    with pytest.raises(BadInputError, match=r"no_such\.csv"):
        calibrate("no_such.csv")


def test_the_result_writes_its_page_and_its_card_and_judges_itself(answer, tmp_path):
    answer.write_page(tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "<svg" in page
    assert "KIAS" in page
    answer.write_card(str(tmp_path / "card.csv"))
    rows = list(csv.DictReader((tmp_path / "card.csv").open(encoding="utf-8")))
    assert float(rows[0]["correction_kt"]) == pytest.approx(answer.curve.correction_kt[0], abs=1e-3)
    assert answer.judge("far23")[0].rule.startswith("FAR 23")
    assert answer.judge("none") == []
    old, *_ = answer.params("px4,ASPD_SCALE_1=1,SENS_DPRES_OFF=0").settings
    assert (old.name, old.old) == ("ASPD_SCALE_1", 1.0)
    for wrong in (
        lambda: answer.write_page(tmp_path / "page.pdf"),
        lambda: answer.write_card(tmp_path / "card.txt"),
        lambda: answer.judge("far99"),
        lambda: answer.params("px4"),
        lambda: answer.params("inav"),
    ):
        with pytest.raises(BadInputError):
            wrong()


def test_the_public_names_are_shown_alone():
    assert dir(pitotbench) == sorted(pitotbench.__all__)
    assert not {"Any", "import_module", "TYPE_CHECKING"} & set(dir(pitotbench))
