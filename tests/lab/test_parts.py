"""The score by part: what counts as right, and the proper scores."""

from typing import get_args

import numpy as np
import pytest

from pitotbench.effects.effect import Part
from pitotlab.blind import parts
from pitotlab.blind.case import JudgedCase
from pitotlab.blind.outsiders import OUTSIDERS


def case(
    hidden: str, kind: str = "above 7", verdict: str = "one_of", **probabilities: float
) -> JudgedCase:
    effects = [{"name": hidden, "strengths": [30.0], "part": None}]
    first, *others = probabilities
    answer = {"kind": verdict, "effects": [first], "alternatives": [others]}
    truth = {"kind": kind, "settings": ["A"], "effects": effects}
    return JudgedCase(truth, answer | {"probabilities": probabilities})


def test_every_fault_outside_the_table_has_parts_of_the_table():
    assert set(parts.PARTS_OUTSIDE) == set(OUTSIDERS)
    assert set().union(*parts.PARTS_OUTSIDE.values()) <= set(get_args(Part)) - {""}


def test_causes_of_one_part_are_summed_and_a_part_is_named_where_no_cause_is():
    found = case("water_in_line", pitot_lag=0.6, water_in_line=0.35, static_lag=0.02)
    assert parts.hidden_parts(found) == {"pitot line"}
    assert parts.summed(found) == pytest.approx({"pitot line": 0.95, "static ports and line": 0.02})
    counted = parts.named_parts([found, case("mass", belly_pod=0.7, turn_drag=0.25)], parts.summed)
    assert (counted.cases, counted.first, counted.right, counted.wrong) == (2, 1, 1, 1)
    assert parts.named_parts([case("mass", verdict="unknown", mass=0.95)], parts.summed).right == 0


def test_the_proper_scores_are_those_computed_by_hand():
    found = case("static_lag", pitot_lag=0.8)
    log, brier = parts.proper_scores([found], parts.summed)
    assert log == pytest.approx(-np.log(0.2) - np.log(parts.LEAST))
    assert brier == pytest.approx(0.8**2 + (1.0 - parts.LEAST) ** 2)
