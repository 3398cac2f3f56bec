"""Causes that are found in flights of their own, each laid out with the model: what takes too long for
the tests of the product, which hold quicker witnesses.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from tests.lab.recovery.test_formula import judged
from tests.reconciliation.outside_table import flown
from tests.reconciliation.test_naming import FEW, LACKING
from tests.reconciliation.test_naming import judged as judged_alone

from pitotbench import Case, fly, sense
from pitotbench.bench.workflow import NamedLog, formula_of, judge_logs
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.fitting import fit_gaps
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.null_distribution import theoretical_distribution
from pitotbench.reconciliation.other_flights import hold_out
from pitotbench.reconciliation.pictures import clearest_channel, traces
from pitotbench.reconciliation.renewal import at_sizes
from pitotbench.reconciliation.verdict import judge
from pitotbench.records.case import EffectSpec


def test_a_flight_without_a_gap_has_no_formula_and_beside_one_a_gap_does_not_bend_the_error_curve(
    tmp_path,
):
    """The left fuel flow reads 8 % low. Without the formula the curve seems to be wrong."""
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


def test_a_hidden_effect_of_another_twin_is_named():
    true = 0.2  # m²
    pod = EffectSpec("belly_pod", {"drag_area_m2": true})
    case = Case(aircraft="c310", maneuver="rapid_decel", truth_seed=21, effects=(pod,))
    layout = lay_out(
        sense(fly(case), "20/20"), aircraft_model("c310"), AnalysisSetting(day_known=True), FEW
    )
    assert not LACKING & {signature.effect for signature in layout.signatures}
    verdict = judge(["flight"], [layout], [theoretical_distribution(layout)]).verdict
    assert [each.name for each in verdict.effects] == ["belly_pod"]
    size = verdict.effects[0].sizes[0]
    assert abs(size.value - true) < size.two_sigma < 0.5 * true
    assert [
        note
        for note in verdict.notes
        if "model of the aircraft lacks" in note and "governor_speed" in note
    ]


def test_the_picture_of_a_late_pitot_line_is_airspeed_in_the_acceleration(flight) -> None:
    late = (
        EffectSpec("pitot_lag", {"lag_s": 1.0}),
    )  # without null flights a lag must be large to be told
    log = sense(replace(flight, case=replace(flight.case, effects=late)), "20/20")
    _, found = judge_logs([NamedLog("log", log)], "none")
    (gap,) = found.verdict.gaps
    assert gap.causes[0].name == "pitot_lag"
    (shown,) = found.shown
    drawn = clearest_channel(shown.block, gap.part, traces(shown.block, shown.fit))
    assert (drawn.channel, drawn.variable) == ("airspeed_along", "acceleration")


def test_a_large_error_shows_in_two_minutes_without_null_flights(flight) -> None:
    """The gap once counted as the noise of so short a log. Late and smoothed look alike in it."""
    late = (EffectSpec("gps_latency", {"latency_s": EFFECTS["gps_latency"].parameters[0].high}),)
    log = sense(replace(flight, case=replace(flight.case, effects=late)), "50/50")
    short = replace(log.select(log.time - log.time[0] < 120.0), header={})
    (gap,) = judged_alone(short).gaps
    assert gap.part == "GPS receiver and its clock"
    assert {cause.name for cause in gap.causes} & {"gps_latency", "gps_smoothing"}


def test_a_held_out_log_is_closed_by_the_shape_that_was_fitted() -> None:
    """With the typical airspeed of a narrow static error, not the fitted one, nothing closes."""
    bump = Catalog("effect", {"local_static_bump": EFFECTS["local_static_bump"]})
    hidden = EffectSpec(
        "local_static_bump", {"coefficient": 0.05, "center_mps": 55.0, "width_mps": 4.0}
    )
    logs = [
        sense(
            fly(Case(maneuver="rapid_decel", truth_seed=seed, sensor_seed=seed, effects=(hidden,))),
            "20/20",
        )
        for seed in (33_001, 33_002)
    ]
    layout = lay_out(logs[0], None, AnalysisSetting(), bump)
    null = theoretical_distribution(layout)
    fitted = fit_gaps([layout], [null])
    assert [member.name for member in fitted.members] == ["local_static_bump"]
    shapes = fitted.regression.blocks[0].layout.signatures[0].shapes
    assert shapes["center_mps"] == pytest.approx(55.0, abs=3.0)
    assert hold_out(partial(lay_out, logs[1], None, layout.setting), null, fitted).share > 0.9


def test_a_shape_that_a_flight_does_not_reach_has_no_signature(flight) -> None:
    """A polar that bends at a lift coefficient of 1.2; the typical one bends at 0.4."""
    bend = Catalog("effect", {"polar_bend": EFFECTS["polar_bend"]})
    layout = lay_out(sense(flight, "20/20"), aircraft_model("navajo"), AnalysisSetting(), bend)
    shown = at_sizes(layout, {("polar_bend", "factor"): 0.1}, {"polar_bend": {"onset": 1.2}})
    (old,), (new,) = layout.signatures, shown.signatures
    assert np.any(old.column)
    assert np.abs(new.column).max() < 0.05 * np.abs(old.column).max()
    assert new.shapes == {"onset": 1.2}
