"""The page and the document: whole, self-contained, every number from the evidence, every picture
there.
"""

import re

import pytest
from tests.lab.study import made_up

from pitotbench.records import BadInputError
from pitotlab.__main__ import main
from pitotlab.study.claims import CLAIMS
from pitotlab.study.conduct import StudyRequest, run_study
from pitotlab.study.content import study_page_of
from pitotlab.study.page import study_html, write_document
from pitotlab.study.sweeps import SWEEPS
from pitotlab.study.tables import TABLES


def _varied(sortie, look):
    return 0.5 + 0.01 * sortie.case.truth_seed + 0.001 * len(look.das)


@pytest.fixture(scope="module")
def page():
    evidence = made_up.evidence(_varied, seeds=2)
    return study_page_of(
        evidence, {number: claim.answer(evidence) for number, claim in CLAIMS.items()}
    )


def test_the_page_is_whole_and_self_contained(page):
    html = study_html(page)
    for number in CLAIMS:
        assert f'id="{number}"' in html
    for sweep in SWEEPS.values():
        assert sweep.question in html
    assert not re.search(r'(src|href)="https?:', html)
    assert html.count("<svg") > 30


def test_every_picture_has_units_on_its_axes(page):
    charts = [
        chart
        for parts in (page.claims, page.truth, page.questions)
        for part in parts
        for chart in part.charts
    ]
    assert all("[" in chart.ylabel for chart in charts)
    assert all("[" in chart.xlabel for chart in charts if hasattr(chart, "xlabel"))
    names = [chart.name for chart in charts]
    assert len(names) == len(set(names))


def test_the_document_and_its_pictures_agree(page, tmp_path):
    text = write_document(page, tmp_path).read_text(encoding="utf-8")
    named = set(re.findall(r"\(study/([^)]+)\)", text))
    assert named == {path.name for path in (tmp_path / "study").iterdir()}
    assert "Seeds 1 to 2" in text


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


def test_numbers_are_told_again_without_flying(tmp_path, capsys):
    """The tables of a run give its pages again; a folder without them is refused with the way out."""
    evidence = made_up.evidence(_varied, seeds=1)
    for name in TABLES:
        getattr(evidence, name).to_parquet(tmp_path / f"{name}.parquet", index=False)
    again = run_study(StudyRequest(out=tmp_path / "again", tables=tmp_path))
    assert {n: f.ours for n, f in again.findings.items()} == {
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


def test_the_claims_alone_are_answered_without_the_sweeps(tmp_path):
    """Every claim answers from fewer flights with the same words; nothing of what was not flown is
    shown.
    """
    whole, alone = (made_up.evidence(_varied, seeds=2, sweeps=sweeps) for sweeps in (True, False))
    assert len(alone.flights) < len(whole.flights)
    findings = {number: claim.answer(alone) for number, claim in CLAIMS.items()}
    assert {n: f.ours for n, f in findings.items()} == {
        n: c.answer(whole).ours for n, c in CLAIMS.items()
    }
    page = study_page_of(alone, findings)
    assert page.questions == []
    assert "Open questions" not in study_html(page)
    assert "left open" not in write_document(page, tmp_path).read_text(encoding="utf-8")
