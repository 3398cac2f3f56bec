"""A formula that was written into an airplane's file is found again, and closes another flight."""

import re
from dataclasses import replace
from functools import partial

import pytest
from tests.lab.recovery.test_formula import SETTING, judged
from tests.reconciliation.outside_table import OUTSIDERS, flown

from pitotbench.bench.workflow import formula_of, patch_of
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.other_flights import hold_out
from pitotbench.show.gap_words import formula_sentences


def test_the_drag_in_sideslip_is_found_with_its_coefficient_and_closes_another_flight(tmp_path):
    hidden = OUTSIDERS["drag in sideslip"]  # 3 sin²β more drag
    log, held = (flown(hidden, seed, tmp_path, "20/20") for seed in (41, 42))
    found = judged(log)
    formula = formula_of(found)
    (term,) = formula.terms
    assert (term.quantity, term.symbol, term.term) == ("drag", "ΔC_D", "sin²β")
    assert abs(term.size.value - 3.0) < term.size.two_sigma < 0.75
    said = r"The gap follows a formula: drag: ΔC_D = \(\d\.\d+ ± 0\.\d+\) sin²β; ± is 2σ\."
    assert re.match(said, formula_sentences(formula)[0])
    assert found.verdict.kind == "unknown"
    assert found.verdict.closure.share > 0.9
    ((name, sizes),) = patch_of(found, "log", "2026-01-01").entries
    assert name == "drag_formula"
    assert sizes["sideslip_squared"] == pytest.approx(term.size.value, rel=1e-4)
    null, model = found.fitted.regression.blocks[0].null, aircraft_model("navajo")
    assert hold_out(partial(lay_out, held, model, SETTING), null, found.fitted).share > 0.8
    fewer = replace(held, velocity_down=None)  # the flight held out may lack a channel
    assert hold_out(partial(lay_out, fewer, model, SETTING), null, found.fitted).share > 0.8
