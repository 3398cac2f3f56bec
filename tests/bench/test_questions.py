"""From Python the bench answers as from the command line: what to fly, and which effect the simulation lacks."""

import pytest

import pitotbench
from pitotbench import Case, PlanRequest, fly, plan, reconcile, sense
from pitotbench.records.case import EffectSpec


def test_a_plan_from_python_chooses_among_the_maneuvers_of_the_request():
    answer = plan(PlanRequest(Case(), draws=2, maneuvers=("rapid_decel", "decel_circle")))
    assert isinstance(answer, pitotbench.Plan)
    assert {forecast.maneuver for forecast in answer.forecasts} == {"rapid_decel", "decel_circle"}
    assert answer.best is answer.forecasts[0]
    assert answer.flights_searched == 0


@pytest.fixture(scope="module")
def late():
    """A flight whose GPS is 0.3 s late, and another one held out."""
    effects = (EffectSpec("gps_latency", {"latency_s": 0.3}),)
    cases = [Case(maneuver="rapid_decel", truth_seed=seed, effects=effects) for seed in (31, 32)]
    return [sense(fly(case), "20/20") for case in cases]


def test_a_reconciliation_from_python_names_the_effect_on_both_flights(late):
    said = []
    answer = reconcile(late[0], aircraft="none", holdout=late[1], refly=False, progress=said.append)
    verdict = answer.reconciliation.verdict
    assert isinstance(verdict, pitotbench.Verdict)
    assert [effect.name for effect in verdict.effects] == ["gps_latency"]
    assert verdict.effects[0].sizes[0].value == pytest.approx(0.3, abs=0.05)
    assert verdict.closure_holdout is not None
    assert verdict.closure_holdout.after < verdict.closure_holdout.before
    assert answer.account.flown.skipped
    assert answer.account.holdout
    assert said
