"""The doubt in a probability: what sealed cases were worth, its limits, and what it makes of a
name.
"""

from dataclasses import replace

import pytest

from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.reconciliation.verdict import Checks, calibrated, doubt_beside, parts_of, verdict_of
from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import Candidate, Closure, Verdict

GAP = Closure(1000.0, 100.0, 100.0)


def verdict(**probabilities: float) -> Verdict:
    """A verdict that names the first of some causes."""
    named = next(iter(probabilities))
    effect = Candidate(named, (), 20.0, probabilities[named])
    return Verdict(
        "named", (effect,), ((),), (effect,), (), (), GAP, (), (), probabilities=probabilities
    )


def test_a_probability_is_worth_what_sealed_cases_were():
    # Of 113 causes above 0.995 whose answer closed all but 3 % of the gap, 108 were right; of 31
    # others 24.
    assert calibrated({"turn_drag": 0.9999}, 0.01)["turn_drag"] == pytest.approx(
        108 / 113, abs=0.03
    )
    assert calibrated({"turn_drag": 0.9999}, 0.08)["turn_drag"] == pytest.approx(24 / 31, abs=0.05)


@pytest.mark.parametrize(
    ("told", "right", "cases"),
    [
        (0.55, 33, 56),
        (0.65, 16, 24),
        (0.75, 26, 34),
        (0.85, 32, 39),
        (0.95, 42, 48),
        (0.99, 24, 32),
    ],
)
def test_a_probability_below_certainty_is_worth_what_the_causes_of_closed_gaps_were(
    told, right, cases
):
    # The fifth to the tenth set: causes of the table by the posterior's own probability, and how
    # many were right.
    share = right / cases
    three_sigma = 3.0 * (share * (1.0 - share) / cases) ** 0.5
    assert calibrated({"turn_drag": told}, 0.0)["turn_drag"] == pytest.approx(
        share, abs=three_sigma
    )


def test_calibrated_odds_rise_with_the_odds():
    told = [i / 1000.0 for i in range(1, 1000)]
    found = [calibrated({"mass": p}, 0.0)["mass"] for p in told]
    assert found == sorted(found)
    assert calibrated({"mass": 1.0}, 0.0)["mass"] < 0.97  # certainty is not reached


def test_doubt_grows_with_what_is_left_and_keeps_the_order():
    found = [
        calibrated({"mass": 0.99, "belly_pod": 0.3, "creep": 0.0}, left)
        for left in (-0.1, 0.0, 0.1, 0.5, 1.0)
    ]
    assert found[0] == found[1]
    assert found[3] == found[4]
    assert [each["mass"] for each in found] == sorted(
        (each["mass"] for each in found), reverse=True
    )
    assert all(each["mass"] > each["belly_pod"] > each["creep"] == 0.0 for each in found)


def test_a_sure_cause_of_a_closed_gap_is_named_and_a_half_open_gap_leaves_a_second_one():
    checks = Checks(verdict(turn_drag=0.9999, belly_pod=0.01))
    told = verdict_of(replace(checks, left=0.01))
    assert (told.kind, told.alternatives, told.changes) == ("named", ((),), ())
    assert told.effects[0].probability == told.probabilities["turn_drag"] > 0.9
    told = verdict_of(replace(checks, left=0.1))
    assert (told.kind, told.alternatives) == ("one_of", (("belly_pod",),))
    (probability,) = (effect.probability for effect in told.effects)
    assert probability < 0.9
    assert told.changes == (
        f"named -> one_of: the doubt of the table (probability {probability:.2f})",
    )


def test_what_a_check_speaks_against_is_worth_what_such_names_were():
    # Of 53 names with a check against them 21 were right: 16 of 34 that closed 0.8 of the gap, 5 of
    # 19 others.
    checks = Checks(verdict(turn_drag=0.9999, belly_pod=0.01))
    less = replace(checks, left_out=("a check",))
    assert verdict_of(replace(less, left=0.08)).probabilities["turn_drag"] == pytest.approx(
        16 / 34, abs=0.1
    )
    back = replace(checks, contradictions=("a check",), left=0.4)
    assert verdict_of(back).probabilities["turn_drag"] == pytest.approx(5 / 19, abs=0.1)
    later = Checks(
        verdict(mass=0.9999, creep=0.01), left=0.08, doubt=doubt_beside(verdict_of(less))
    )
    assert verdict_of(later).kind == "one_of"  # a further pass is worth no more than the first one


def test_the_part_of_two_causes_is_named_where_neither_is():
    either = replace(
        verdict(pitot_lag=0.6, water_in_line=0.4), kind="one_of", alternatives=(("water_in_line",),)
    )
    found = verdict_of(Checks(either, left=0.0))
    assert found.named_parts == ("pitot line",)
    assert found.parts["pitot line"] > THRESHOLDS.named_from > found.probabilities["pitot_lag"]
    unknown = verdict_of(
        Checks(verdict(pitot_lag=0.6, water_in_line=0.4), contradictions=("a check",), left=0.0)
    )
    assert unknown.named_parts == ()


def test_a_part_is_no_less_probable_than_its_causes_and_a_counted_fault_has_one():
    told = parts_of({"pitot_lag": 0.97, "mass": 0.02})
    assert told["pitot line"] == 0.97
    assert list(told) == ["pitot line", "loading"]
    counted = replace(verdict(mass=0.05), effects=(Candidate("dropped_samples", (), 99.0),))
    assert verdict_of(Checks(counted, left=0.0)).named_parts == ("recorder",)
    assert verdict_of(Checks(counted, left=0.1)).kind == "named"  # what was counted is certain


def test_a_candidate_of_the_answer_has_the_sizes_of_the_answer():
    plain, wide = Estimate("lag_s", 0.4, 0.05), Estimate("lag_s", 0.4, 0.1)
    named = verdict(pitot_lag=0.9999)
    effect = replace(named.effects[0], sizes=(wide,))
    listed = (replace(effect, sizes=(plain,)), Candidate("mass", (plain,), 1.0))
    told = verdict_of(Checks(replace(named, effects=(effect,), candidates=listed), left=0.0))
    assert [each.sizes for each in told.candidates] == [(wide,), (plain,)]
