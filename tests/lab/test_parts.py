"""The score by part: what counts as right, what a table tells, and that the product's table is that
of the sets.
"""

from typing import get_args

import numpy as np
import pytest

from pitotbench.effects.effect import Part
from pitotbench.reconciliation.verdict import part_table, parts_of
from pitotlab.blind import parts
from pitotlab.blind.case import JudgedCase
from pitotlab.blind.outsiders import OUTSIDERS
from pitotlab.blind.sealed import judged_in, kept_sets


def case(
    hidden: str, kind: str = "above 7", verdict: str = "one_of", **probabilities: float
) -> JudgedCase:
    truth = {
        "kind": kind,
        "settings": ["A"],
        "effects": [{"name": hidden, "strengths": [30.0], "part": None}],
    }
    first, *others = probabilities
    answer = {
        "kind": verdict,
        "effects": [first],
        "alternatives": [others],
        "probabilities": probabilities,
    }
    return JudgedCase(truth, answer)


def test_every_fault_outside_the_table_has_parts_of_the_table():
    assert set(parts.PARTS_OUTSIDE) == set(OUTSIDERS)
    assert {part for parts in parts.PARTS_OUTSIDE.values() for part in parts} <= set(
        get_args(Part)
    ) - {""}


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


def test_a_table_rises_with_the_sum_and_a_part_is_no_less_probable_than_its_cause():
    cases = [case("pitot_lag", pitot_lag=0.6) for _ in range(8)] + [
        case("mass", pitot_lag=0.6) for _ in range(2)
    ]
    sums, shares, count = parts.fitted_table([*cases, *(case("mass", mass=0.95) for _ in range(5))])
    assert np.all(np.diff(shares) >= 0.0)
    assert count[1:].sum() == 17
    assert np.interp(0.6, sums, shares) == pytest.approx((8 + 2 * 0.6) / 12)
    assert parts.told_by(np.array([0.0, 1.0]), np.array([0.0, 0.5]))(case("mass", mass=0.9)) == {
        "loading": 0.9
    }


def test_the_table_of_the_product_is_that_of_the_kept_sets_and_tells_what_the_product_tells():
    sets = [path.name.split(".")[0] for path in kept_sets()]
    cases = [each for path in kept_sets() for each in judged_in(path)]
    assert parts.TABLE.read_text("utf-8") == parts.text_of(sets, parts.fitted_table(cases))
    sums, shares = part_table()
    assert np.all(np.diff(sums) > 0.0)
    assert np.all(np.diff(shares) >= 0.0)
    assert shares[-1] < 1.0
    found = case("pitot_lag", pitot_lag=0.5, water_in_line=0.2, static_lag=0.1)
    assert parts_of(found.probabilities) == pytest.approx(dict(parts.kept_table()(found)))
