"""An airplane of JSBSim's library as the analyst's model: what it cannot take is left out and said."""

import pytest

from pitotbench import Case, fly, sense
from pitotbench.bench.null_flights import aircraft_model
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import AircraftEffect
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.null_distribution import theoretical_distribution
from pitotbench.reconciliation.verdict import judge
from pitotbench.records.case import EffectSpec

# It declares no speed of its governors, and its engines state no fuel flow for their power.
LACKING = {"governor_speed", "power_deficit"}
FEW = Catalog(
    "effect", {n: EFFECTS[n] for n in ("belly_pod", "mass", "pitot_lag", "gps_latency", *sorted(LACKING))}
)


def test_the_bench_s_own_twin_takes_every_effect_and_another_does_not():
    for aircraft, lacking in (("navajo", set()), ("c310", LACKING)):
        baseline = aircraft_model(aircraft).baseline
        effects = {name: each for name, each in EFFECTS.items() if isinstance(each, AircraftEffect)}
        assert {name for name, each in effects.items() if not each.fitting(baseline)} == lacking


@pytest.mark.parametrize(
    ("effect", "parameter", "true"), [("pitot_lag", "lag_s", 0.5), ("belly_pod", "drag_area_m2", 0.2)]
)
def test_a_hidden_effect_of_another_twin_is_named(effect, parameter, true):
    case = Case(
        aircraft="c310", maneuver="rapid_decel", truth_seed=21, effects=(EffectSpec(effect, {parameter: true}),)
    )
    layout = lay_out(sense(fly(case), "20/20"), aircraft_model("c310"), AnalysisSetting(day_known=True), FEW)
    assert not LACKING & {signature.effect for signature in layout.signatures}
    verdict = judge(["flight"], [layout], [theoretical_distribution(layout)]).verdict
    assert [each.name for each in verdict.effects] == [effect]
    size = verdict.effects[0].sizes[0]
    assert abs(size.value - true) < size.two_sigma < 0.5 * true
    assert [note for note in verdict.notes if "model of the aircraft lacks" in note and "governor_speed" in note]


def test_the_force_meter_takes_what_an_airplane_has():
    """One engine has one throttle; the thrust of a turboprop, which comes to its power slowly, is not known."""
    single, twin, turboprop = (aircraft_model(name) for name in ("c172x", "c310", "DHC6"))
    assert "throttle_right" not in single.controls
    assert set(twin.controls) - set(single.controls) == {"throttle_right"}
    assert twin.thrust_known
    assert not turboprop.thrust_known
