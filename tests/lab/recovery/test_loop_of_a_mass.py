"""The loop adds a mass that nobody weighed once."""

import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from pitotbench import Case, fly, reconcile, sense
from pitotbench.records.case import EffectSpec

UNWEIGHED = 180.0  # kg


@pytest.mark.long
def test_a_mass_that_nobody_weighed_is_patched_once(tmp_path, monkeypatch):
    """Fuel burnt to the logged mass took the patch out again, and four rounds wrote 600 kg."""
    monkeypatch.chdir(tmp_path)
    load = (EffectSpec("mass", {"mass_kg": UNWEIGHED}),)
    case = Case(maneuver="rapid_decel", turbulence="none", truth_seed=99, effects=load)
    found = reconcile(replace(sense(fly(case), "20/5"), header={}), close="fixed", refly=False)
    (size,) = found.sizes["mass"]
    closing = found.account.closing
    assert len(closing.closed) == 1
    assert closing.verdict.kind == "no_gap"
    text = Path("aircraft/navajo+fixed/variant.toml").read_text(encoding="utf-8")
    (patched,) = tomllib.loads(text)["effects"]
    assert abs(patched["parameters"]["mass_kg"] - size.value) < 0.1
    assert abs(patched["parameters"]["mass_kg"] - UNWEIGHED) < size.two_sigma
