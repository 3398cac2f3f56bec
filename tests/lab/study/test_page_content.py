"""The page: whole, self-contained, every number from the evidence, every picture there."""

import re
from dataclasses import replace

import pytest
from tests.lab.study import made_up

from pitotbench.records import BadInputError
from pitotlab.__main__ import main
from pitotlab.study.claims import CLAIMS
from pitotlab.study.conduct import StudyRequest, run_study
from pitotlab.study.content import study_page_of
from pitotlab.study.page import study_html
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
def page(told):
    return study_page_of(told.evidence, told.findings)


def test_the_page_is_whole_and_self_contained(told):
    html = told.page.read_text("utf-8")
    for number in CLAIMS:
        assert f'id="{number}"' in html
    for sweep in SWEEPS.values():
        assert sweep.question in html
    assert not re.search(r'(src|href)="https?:', html)
    assert html.count("<svg") > 30
    assert "Seeds 1 to 2" in html


def test_every_picture_has_units_on_its_axes(page):
    parts = (*page.claims, *page.truth, *page.questions)
    charts = [chart for part in parts for chart in part.charts]
    assert all("[" in chart.ylabel for chart in charts)
    assert all("[" in chart.xlabel for chart in charts if hasattr(chart, "xlabel"))


@pytest.mark.parametrize("name", SWEEPS)
def test_a_sweep_answers_in_two_or_three_sentences(name, page):
    (part,) = [p for p in page.questions if p.anchor == name.replace(" ", "-")]
    words = part.lines[0][1]
    assert 2 <= len(re.findall(r"[.](?: |$)", words)) <= 4
    assert part.charts


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


def test_the_claims_alone_are_answered_without_the_sweeps(evidence, told, page):
    """The same words and pictures from fewer flights, and nothing of what was not flown."""
    alone = made_up.evidence(_varied, seeds=2, sweeps=False)
    assert len(alone.flights) < len(evidence.flights)
    findings = {number: claim.answer(alone) for number, claim in CLAIMS.items()}
    assert {n: f.ours for n, f in findings.items()} == {n: f.ours for n, f in told.findings.items()}
    fewer = study_page_of(alone, findings)
    assert [repr(part.charts) for part in fewer.claims] == [repr(p.charts) for p in page.claims]
    assert fewer.questions == []
    words = replace(fewer, claims=[replace(part, charts=()) for part in fewer.claims])
    assert "Open questions" not in study_html(words)
