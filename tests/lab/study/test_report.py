"""The report: whole, every number from the evidence, the same without a flight."""

import re

import pytest
from tests.lab.study import made_up

from pitotbench.records import BadInputError
from pitotlab.__main__ import main
from pitotlab.study.claims import CLAIMS
from pitotlab.study.conduct import StudyRequest, run_study
from pitotlab.study.content import study_text
from pitotlab.study.sweeps import SWEEPS
from pitotlab.study.tables import TABLES


def _varied(sortie, reduction):
    return 0.5 + 0.01 * sortie.case.truth_seed + 0.001 * len(reduction.das)


@pytest.fixture(scope="module")
def evidence():
    return made_up.evidence(_varied, seeds=2)


@pytest.fixture(scope="module")
def told(evidence, tmp_path_factory):
    """The study told again from the tables of a run, with its page."""
    folder = tmp_path_factory.mktemp("study")
    for name in TABLES:
        getattr(evidence, name).to_parquet(folder / f"{name}.parquet", index=False)
    return run_study(StudyRequest(out=folder / "again", tables=[folder]))


@pytest.fixture(scope="module")
def told_text(told):
    return told.page.read_text("utf-8")


def test_the_report_is_whole(told, told_text):
    for number, finding in told.findings.items():
        assert f"## {number}: {finding.verdict}" in told_text
        assert finding.why in told_text
    for sweep in SWEEPS.values():
        assert sweep.question in told_text
    assert "Seeds 1 to 2" in told_text
    tables = sum(len(finding.tables) for finding in told.findings.values())
    assert told_text.count("|---") > tables > 10


@pytest.mark.parametrize("name", SWEEPS)
def test_a_sweep_answers_in_two_or_three_sentences(name, told_text):
    after = told_text.partition(SWEEPS[name].question)[2]
    words = after.split("\n\n")[1]
    assert 2 <= len(re.findall(r"[.](?: |$)", words)) <= 4


def test_seeds_count_from_one(capsys):
    with pytest.raises(BadInputError, match="count from 1"):
        StudyRequest(seeds=0)
    assert main(["study", "--seeds", "0"]) == 2
    assert "count from 1" in capsys.readouterr().err


def test_numbers_are_told_again_without_flying(evidence, told, tmp_path, capsys):
    """The tables of a run give its pages again; a folder without them is refused with the way out."""
    assert {n: f.ours for n, f in told.findings.items()} == {
        n: c.answer(evidence).ours for n, c in CLAIMS.items()
    }
    assert main(["study", "--tables", str(tmp_path / "nothing"), "--out", str(tmp_path / "x")]) == 2
    assert "--tables takes" in capsys.readouterr().err


@pytest.mark.parametrize("out", ["taken", "taken/below", "/proc/out"])
def test_a_folder_that_cannot_be_made_is_refused_before_the_work(
    out, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").write_text("mine")
    assert main(["study", "--out", out]) == 2
    assert out in capsys.readouterr().err
    assert (tmp_path / "taken").read_text() == "mine"


def test_the_claims_alone_are_answered_without_the_sweeps(evidence, told):
    """The same words from fewer fits, and nothing of what was not fitted."""
    alone = made_up.evidence(_varied, seeds=2, sweeps=False)
    assert len(alone.fits) < len(evidence.fits)
    findings = {number: claim.answer(alone) for number, claim in CLAIMS.items()}
    assert {n: f.ours for n, f in findings.items()} == {n: f.ours for n, f in told.findings.items()}
    assert "Open questions" not in study_text(alone, findings)
