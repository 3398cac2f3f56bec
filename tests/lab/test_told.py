"""The worth of what follows the posterior: a map is inverted, and a check counts by what it spoke
against.
"""

import pytest

from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.reconciliation.verdict import calibrated
from pitotlab.blind.case import JudgedCase
from pitotlab.blind.told import OFF, TELLINGS, Telling, rows_of_checks, rows_of_tellings

LAG = {
    "kind": "above 7",
    "settings": ["A"],
    "effects": [{"name": "pitot_lag", "strengths": [30.0], "part": None}],
}


def case(truth: dict, kind: str = "named", closure: float = 1.0, **answer: object) -> JudgedCase:
    probabilities = answer.pop("probabilities", {"pitot_lag": 0.9})
    effects = (
        {"effects": list(probabilities)[:1], "alternatives": [[]]} if kind != "unknown" else {}
    )
    return JudgedCase(
        truth,
        {"kind": kind, "closure": closure, "probabilities": probabilities, **effects, **answer},
    )


@pytest.mark.parametrize("closure", [1.0, 0.95, 0.6])
@pytest.mark.parametrize("p", [1e-4, 0.3, 0.6, 0.75, 0.85, 0.97, 0.999])
def test_a_telling_is_that_of_the_product_and_is_inverted(p: float, closure: float):
    hidden, telling = case(LAG, closure=closure), TELLINGS["eleventh"]
    told = telling.told(hidden, {"pitot_lag": p})
    assert told == pytest.approx(calibrated({"pitot_lag": p}, 1.0 - closure))
    again = telling.posterior(case(LAG, closure=closure, probabilities=told))
    if 0.8 < p < 0.9412:  # odds of 4 to 16 are told as 4
        assert again["pitot_lag"] == pytest.approx(8.0 / 9.0)
    else:
        assert again["pitot_lag"] == pytest.approx(p, rel=1e-3)


def test_an_objection_costs_the_share_of_the_objections():
    doubted = case(LAG, kind="one_of", doubts=["a check"])
    now = Telling(probable=THRESHOLDS.doubt_objected)
    assert now.share(doubted) == pytest.approx((1.0 - 0.04) * (1.0 - THRESHOLDS.doubt_objected))


def test_a_step_that_is_off_changes_the_scores_of_the_set():
    sets = {"seventh": [case(LAG)], "eleventh": [case(LAG), case(LAG, probabilities={"mass": 0.9})]}
    rows = {(row["step off"], row["measured on"][-8:]): row for row in rows_of_tellings(sets)}
    assert len(rows) == 2 * len(OFF)
    assert rows["doubt by objections", "eleventh"]["log_causes"] == "0.0000"  # no check spoke
    assert float(rows["all doubt", "to tenth"]["log_causes"]) < 0.0  # a right name of a closed gap


def test_a_check_counts_by_the_names_that_it_spoke_against():
    doubts, notes = (
        ["pitot_lag comes closest, but closes only 70%"],
        ["x: the name pitot_lag is taken back"],
    )
    back = {"doubts": doubts, "notes": notes}
    fault = LAG | {
        "kind": "outside",
        "effects": [{"name": "loose_tube", "strengths": [30.0], "part": None}],
    }
    sets = {"a": [case(LAG, "unknown", **back), case(fault, "unknown", **back), case(LAG)]}
    rows = {row["check"]: row for row in rows_of_checks(sets)}
    assert [rows["closure of all passes"][n] for n in ("spoke", "right", "partly", "wrong")] == [
        2,
        1,
        0,
        1,
    ]
    assert rows["formula"]["spoke"] == 0
