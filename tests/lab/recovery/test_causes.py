"""Causes that are found in flights of their own, each laid out with the model: what takes too long for
the tests of the product, which hold quicker witnesses.
"""

from dataclasses import replace

import pytest
from tests.reconciliation.outside_table import flown
from tests.reconciliation.test_formula import judged
from tests.reconciliation.test_naming import FEW, LACKING

from pitotbench import Case, fly, sense
from pitotbench.bench.null_flights import aircraft_model
from pitotbench.bench.workflow import formula_of
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.null_distribution import theoretical_distribution
from pitotbench.reconciliation.verdict import judge
from pitotbench.records.case import EffectSpec


def test_a_flight_without_a_gap_has_no_formula_and_beside_one_a_gap_does_not_bend_the_error_curve(
    tmp_path,
):
    """The left fuel flow reads 8 % low, no matter of the error curve. Without the formula it seems
    to be.
    """
    plain = flown(None, 43, tmp_path, "20/20")
    sound = judged(plain)
    low = judged(replace(plain, fuel_flow_left=0.92 * plain.fuel_flow_left))
    assert (sound.verdict.kind, formula_of(sound)) == ("no_gap", None)
    assert formula_of(low) is not None
    (true,), (shown,) = sound.shown, low.shown
    without, bent, beside = (
        each.block.equations.free_sizes(columns)
        for each, columns in ((true, ()), (shown, ()), (shown, shown.fit.columns))
    )
    names = true.block.layout.free.names
    curve = [i for i, name in enumerate(names) if name.startswith("curve")]
    assert len(curve) == 3
    for i in curve:
        assert abs(beside[i] - without[i]) < 0.1 * abs(bent[i] - without[i])


@pytest.mark.parametrize(
    ("effect", "parameter", "true"),
    [("pitot_lag", "lag_s", 0.5), ("belly_pod", "drag_area_m2", 0.2)],
)
def test_a_hidden_effect_of_another_twin_is_named(effect, parameter, true):
    case = Case(
        aircraft="c310",
        maneuver="rapid_decel",
        truth_seed=21,
        effects=(EffectSpec(effect, {parameter: true}),),
    )
    layout = lay_out(
        sense(fly(case), "20/20"), aircraft_model("c310"), AnalysisSetting(day_known=True), FEW
    )
    assert not LACKING & {signature.effect for signature in layout.signatures}
    verdict = judge(["flight"], [layout], [theoretical_distribution(layout)]).verdict
    assert [each.name for each in verdict.effects] == [effect]
    size = verdict.effects[0].sizes[0]
    assert abs(size.value - true) < size.two_sigma < 0.5 * true
    assert [
        note
        for note in verdict.notes
        if "model of the aircraft lacks" in note and "governor_speed" in note
    ]
