"""Python takes what a user has in the hand: a path, a table, a log, a list; and writes what the
command writes.
"""

import csv
import re
from dataclasses import fields, replace
from hashlib import sha256

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import BadInputError, CalibrationOptions, calibrate, inspect, reconcile, write_log
from pitotbench.campaigns.digests import file_sha256
from pitotbench.cli.app import main
from pitotbench.records.calibration import Disagreement, LatencyFound
from pitotbench.records.log import Caution
from pitotbench.show.pages import calibration_record
from pitotbench.show.record import checks_of

# Several voices of one answer are looked at: each log is fitted once.
pytestmark = pytest.mark.usefixtures("one_fit_of_each_log")


@pytest.fixture(scope="module")
def log():
    return fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air())


@pytest.fixture(scope="module")
def answer(log):
    return calibrate(log, model="quadratic")


def test_a_path_a_table_and_a_log_have_one_answer(log, answer, tmp_path):
    """The table has no header, and so not its accuracies and priors: they are stated as keywords."""
    exact = {
        "model": "quadratic",
        "accuracies": fixture.EXACT,
        "priors": fixture.COLUMNS,
        "error_location": "impact",
    }
    of_log = calibrate(log, **exact)
    for each in (
        str(write_log(log, tmp_path / "a.parquet")),
        tmp_path / "a.parquet",
        log.to_frame(),
    ):
        found = calibrate(each, **exact)
        np.testing.assert_allclose(found.curve.correction, of_log.curve.correction, atol=1e-4)
    np.testing.assert_allclose(answer.curve.correction, of_log.curve.correction, atol=1e-6)
    # A list has one curve, and a wind each.
    path = write_log(
        fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air(), seed=2), tmp_path / "b.csv"
    )
    one, other = calibrate([log, path])
    np.testing.assert_allclose(one.curve.correction, other.curve.correction)
    assert one.wind.north.value != other.wind.north.value


@pytest.mark.parametrize("given", [3, None, {"a": 1}, [3], []])
def test_another_kind_is_refused_in_one_sentence(given):
    for function in (calibrate, reconcile):
        with pytest.raises(
            BadInputError, match=r"takes a path, a DataFrame, a log or a list|at least one log"
        ):
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


def test_an_answer_knows_its_file_its_choices_and_the_versions(log, answer, tmp_path):
    path = write_log(log, tmp_path / "a.csv")
    made = calibrate(path, model="quadratic").provenance
    (of,) = made.inputs
    assert (of.name, of.sha256) == ("a.csv", sha256(path.read_bytes()).hexdigest())
    assert (of.rows, of.origin) == (len(log), "measured")
    choices = [f.name for f in fields(CalibrationOptions) if f.name != "accuracies"]
    sources = {each.name: each.source for each in made.choices}
    assert sources == dict.fromkeys(choices, "default") | {"model": "stated"}
    assert {"pitotbench", "Python", "numpy", "scipy", "pandas"} <= set(made.versions)
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", made.date)
    # A log in memory has the digest of its channels: another log has another one.
    assert answer.provenance.inputs == calibrate(log).provenance.inputs
    shorter = calibrate(log.select(np.arange(len(log) - 1)))
    assert shorter.provenance.inputs[0].sha256 != answer.provenance.inputs[0].sha256
    by_options = calibrate(log, CalibrationOptions(model="quadratic")).provenance.choices
    assert by_options == answer.provenance.choices
    # The digest of a folder is that of its files by path.
    (tmp_path / "in" / "c").mkdir(parents=True)
    for name, content in (("b.csv", b"two"), ("a.csv", b"one"), ("c/c.csv", b"three")):
        (tmp_path / "in" / name).write_bytes(content)
    assert file_sha256(tmp_path / "in") == sha256(b"onetwothree").hexdigest()


def test_every_check_passes_or_fails_by_the_records_of_the_answer(answer):
    held = replace(answer, points=("a point", "another"))
    passed = {check.name: check.status for check in checks_of(held)}
    assert passed["the fit converged"] == passed["samples and curve agree"] == "passed"
    assert passed["fixed-speed points and curve agree"] == "passed"
    assert "failed" not in passed.values()
    assert passed["flights agree"] == passed["latency of the GPS velocity"] == "skipped"
    kinds = ("samples", "height", "fixed_speed")
    codes = (
        "latency",
        "wind",
        "confounded",
        "curve size",
        "outside prior",
        "faulty rows",
        "axes turned",
    )
    wrong = replace(
        answer,
        converged=False,
        disagreements=tuple(
            Disagreement(kind, f"off by {kind}", 1.0, fatal=True) for kind in kinds
        ),
        warnings=tuple(Caution(f"wrong: {code}", code) for code in codes),
        left_out=("take-off roll",),
        diagnostics=replace(answer.diagnostics, latency=LatencyFound(0.3, 0.1, 0.3)),
    )
    found = {check.name: check for check in checks_of(wrong)}
    assert sum(check.status == "failed" for check in found.values()) == 1 + len(kinds) + len(codes)
    assert found["latency of the GPS velocity"].why == "wrong: latency"
    assert found["the whole log was used"].status == "skipped"
    assert found["the whole log was used"].why == "left out: take-off roll"


def test_the_record_holds_inputs_choices_answer_rule_and_checks(log, tmp_path):
    path, record = write_log(log, tmp_path / "a & b.csv"), tmp_path / "record.html"
    calibrate(path, model="quadratic").write_record(record, "far23")
    page = record.read_text(encoding="utf-8")
    headings = re.findall("<h2>(.*?)</h2>", page)
    assert headings == ["Objective and inputs", "Settings", "Answer", "Conditions", "Checks"]
    digest = sha256(path.read_bytes()).hexdigest()
    for text in ("a &amp; b.csv", digest, "model: quadratic (stated)", "FAR 23.1323"):
        assert text in page
    assert "<svg" in page
    with pytest.raises(BadInputError, match=r"must end in \.html"):
        calibrate(log).write_record(tmp_path / "record.pdf")


def test_of_several_flights_the_worst_check_is_told_and_a_long_flight_keeps_to_two_pages(answer):
    late = replace(answer, warnings=(Caution("the GPS is late", "latency"),))
    page = calibration_record([answer, late])
    assert "flight 2: the GPS is late" in page
    (window,) = answer.winds
    many = tuple(replace(window, begin=9e8 + 60.0 * k, end=9e8 + 60.0 * (k + 1)) for k in range(40))
    page = calibration_record([replace(answer, winds=many, log_start=9e8)])
    assert "Of 40 windows of the wind, one in 4 is shown" in page
    assert re.findall(r'<tr><td class="text">(\d+:\d+)</td>', page)[:3] == ["0:00", "4:00", "8:00"]


def test_the_command_writes_the_record_and_refuses_what_it_cannot_be(log, tmp_path, capsys):
    one = write_log(log, tmp_path / "one.csv")
    two = write_log(
        fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air(), seed=2), tmp_path / "two.csv"
    )
    record = tmp_path / "record.html"
    assert main(["calibrate", str(one), str(two), "--record", str(record), "--from", "1:00"]) == 0
    page = record.read_text(encoding="utf-8")
    assert all(sha256(path.read_bytes()).hexdigest() in page for path in (one, two))
    assert "from: 1:00 (stated)" in page
    assert "to: the last row (default)" in page
    assert "wind: checked (default)" in page
    assert main(["calibrate", str(one), str(two), "--separately", "--record", str(record)]) == 2
    assert "--record holds one curve" in capsys.readouterr().err
    assert main(["calibrate", str(one), "--record", str(tmp_path / "record.txt")]) == 2
    assert (
        main(
            ["reconcile", str(one), "--aircraft", "none", "--record", str(tmp_path / "record.txt")]
        )
        == 2
    )


def test_inspect_takes_what_calibrate_takes(log, tmp_path):
    path = write_log(log, tmp_path / "a.csv")
    found = [inspect(each) for each in (log, path, str(path), log.to_frame())]
    assert {each.rows for each in found} == {len(log)}
    assert "rows at" in repr(found[0])
    assert set(found[0].to_frame()["name"]) == set(log.channels())
    assert "<table>" in found[0]._repr_html_()
    with pytest.raises(BadInputError, match="inspect takes a path"):
        inspect(3)
