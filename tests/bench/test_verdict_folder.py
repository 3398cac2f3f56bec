"""The folder of a reconciliation, and the patched aircraft that flies by its name."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from pitotbench import BadInputError, NoAnswerError, Verdict, read_log
from pitotbench.bench.verdict_folder import install, keep
from pitotbench.cli.app import main
from pitotbench.reconciliation.patches import patch_of_effects
from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import Candidate, Closure, Gap
from pitotbench.units import INCH_OF_MERCURY

POD = Candidate("belly_pod", (Estimate("drag_area_m2", 0.3, 0.02),), 40.0)
LAG = Candidate("pitot_lag", (Estimate("lag_s", 0.4, 0.02),), 40.0)


def outcome(*effects: Candidate, kind: str = "named"):
    """As much of an outcome as adding needs."""
    gaps = [Gap("drag", 0.9, (each,), True, True, 0.9, 0.9) for each in effects]
    verdict = SimpleNamespace(kind=kind, gaps=gaps, closure=Closure(100.0, 11.0, 10.0))
    account = SimpleNamespace(log="flight.csv", aircraft="navajo", chosen="", flights=())
    made = patch_of_effects(effects, "flight.csv", "2026-01-01")
    return SimpleNamespace(verdict=verdict, account=account, patch=made)


def test_an_applied_patch_flies_in_a_campaign_with_its_drag(tmp_path, monkeypatch, smooth_flights):
    monkeypatch.chdir(tmp_path)
    lines = install(outcome(POD, LAG), "test")
    assert "pitot_lag" in lines[1]
    variant = (tmp_path / "aircraft" / "navajo+test" / "variant.toml").read_text()
    assert "flight.csv" in variant
    assert "two_sigma" in variant
    options = [
        "--maneuver",
        "circle",
        "--das",
        "20/1",
        "--turbulence",
        "none",
        "--jobs",
        "1",
        "--out",
        "out",
    ]
    assert main(["campaign", "--aircraft", "navajo+test", *options]) == 0
    assert len(pd.read_parquet("out/results.parquet")) == 1
    log = read_log(
        next(f for f in (tmp_path / "out").rglob("*.parquet") if f.name != "results.parquet")
    )
    power = np.mean(log.manifold_pressure_left) - np.mean(
        smooth_flights["circle"]["manifold_pressure_left"]
    )
    assert power > 1.0 * INCH_OF_MERCURY  # the pod is paid for


def test_nothing_is_overwritten(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    install(outcome(POD), "test")
    before = (tmp_path / "aircraft" / "navajo+test" / "navajo+test.xml").read_bytes()
    with pytest.raises(BadInputError, match="there already"):
        install(outcome(POD), "test")
    assert (tmp_path / "aircraft" / "navajo+test" / "navajo+test.xml").read_bytes() == before


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        ("--apply test", "there already"),
        ("--apply ../pod", "use letters"),
        ("--apply pod --aircraft none", "name"),
        ("--close test", "choose another name"),
        ("--close pod --aircraft none", "name the aircraft"),
        ("--close pod --apply test2", "give one of them"),
    ],
)
def test_a_name_that_cannot_be_is_refused_before_the_log_is_read(
    flags, says, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    install(outcome(POD), "test")
    assert main(["reconcile", "nowhere.csv", *flags.split()]) == 2
    assert says in capsys.readouterr().err


def test_of_a_set_only_what_the_user_chooses_is_applied(tmp_path):
    doubtful = Candidate("belly_pod", POD.sizes, 40.0, 0.58)
    rival = Candidate("turn_drag", (), 39.0, 0.4)
    gap = Gap("drag", 0.98, (doubtful, rival), False, False, 1.0, 1.0)
    made, closure = outcome(doubtful), Closure(100.0, 11.0, 10.0)
    made.verdict = Verdict("one_of", (gap,), (doubtful,), (), (), closure, (), ())
    with pytest.raises(NoAnswerError, match="to tell belly_pod, turn_drag apart: fly"):
        install(made, "doubtful", tmp_path)
    assert list(tmp_path.iterdir()) == []
    made.account.chosen = "belly_pod"
    install(made, "chosen", tmp_path)
    text = (tmp_path / "navajo+chosen" / "variant.toml").read_text(encoding="utf-8")
    assert 'chosen = "belly_pod"' in text
    assert 'name = "belly_pod"' in text


def test_a_size_beyond_its_range_is_not_applied(tmp_path):
    large = Candidate("belly_pod", (Estimate("drag_area_m2", 9.0, 0.2),), 40.0)
    with pytest.raises(NoAnswerError, match="range ends at"):
        install(outcome(large), "large", tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (outcome(LAG), "case file"),
        (outcome(kind="no_gap"), "no significant gap"),
        (outcome(kind="unknown"), "unknown"),
    ],
)
def test_an_answer_that_cannot_be_applied_is_refused_with_a_reason(made, message, tmp_path):
    with pytest.raises(BadInputError, match=message):
        install(made, "test", tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_the_folder_holds_verdict_patch_report_and_overlay(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "pitotbench.bench.verdict_folder.account_page", lambda account, units: "<html></html>"
    )
    keep(outcome(POD), {"verdict": "named"}, tmp_path)
    assert {f.name for f in tmp_path.iterdir()} == {
        "overlay.xml",
        "patch.toml",
        "report.html",
        "verdict.json",
    }
    keep(
        outcome(LAG), {"verdict": "named"}, tmp_path
    )  # an earlier overlay does not outlive its patch
    assert not (tmp_path / "overlay.xml").exists()
