"""The loop writes no airplane for a gap that is a sensor's."""

from dataclasses import replace
from pathlib import Path

from pitotbench import Case, fly, reconcile, sense
from pitotbench.records.case import EffectSpec


def test_without_a_gap_of_the_airplane_nothing_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bias = (EffectSpec("temperature_bias", {"bias_k": 4.0}),)
    case = Case(maneuver="rapid_decel", turbulence="none", truth_seed=22, effects=bias)
    found = reconcile(replace(sense(fly(case), "20/5"), header={}), close="found", refly=False)
    assert found.account.closing.closed == ()
    assert [each.causes[0].name for each in found.account.closing.reported] == ["temperature_bias"]
    assert not Path("aircraft").exists()
