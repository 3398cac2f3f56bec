"""A vane that is off leaves no force, which a pod would, and the slope of the lift as it is."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import Case, Flight, fly, sense
from pitotbench.catalog import Catalog
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.free_parameters import (
    BIAS,
    AnalysisSetting,
    fit_free_parameters,
)
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.null_distribution import theoretical_distribution
from pitotbench.reconciliation.verdict import judge
from pitotbench.records.case import EffectSpec
from pitotbench.units import Array

NO_EFFECTS = Catalog("effect", {})


def with_vane(flight: Flight, *effects: EffectSpec) -> tuple[Layout, Array]:
    """The flight laid out with effects, and what is left of its two forces (rms)."""
    log = sense(replace(flight, case=replace(flight.case, effects=effects)), "50/50")
    setting = AnalysisSetting(day_known=True, instruments_known=True)
    layout = lay_out(log, aircraft_model("navajo"), setting, NO_EFFECTS)
    left = fit_free_parameters(layout.residuals.values, layout.free, layout.used).residuals
    places = [layout.residuals.places[name] for name in ("specific_force_x", "specific_force_z")]
    return layout, np.sqrt(np.mean(left[:, places] ** 2, axis=0))


@pytest.fixture(scope="module")
def sound_forces(flight: Flight) -> Array:
    return with_vane(flight)[1]


def test_a_vane_that_is_off_leaves_no_force(flight: Flight, sound_forces: Array) -> None:
    """Lift and drag are not linear in alpha: two degrees of a vane's zero looked like a pod."""
    offset_deg, scale = -3.0, 0.2
    effect = EffectSpec("alpha_vane_calibration", {"scale": scale, "offset_deg": offset_deg})
    layout, forces = with_vane(flight, effect)
    alpha, angles = layout.track["angle_of_attack"], layout.angles
    left = (
        (angles["angle_of_attack scale"] - scale) * alpha
        + angles["angle_of_attack bias"]
        - np.radians(offset_deg)
    )
    assert np.sqrt(np.mean(left**2)) < BIAS["angle_of_attack"]
    assert np.all(forces < 1.1 * sound_forces)


def test_a_vane_that_is_off_beside_a_lift_slope_leaves_both_their_sizes() -> None:
    """By the model's slope, not the airplane's, it came out 5 % too steep, the scale at 0.11."""
    slope, scale = -0.25, 0.14
    effects = (
        EffectSpec("lift_slope", {"change": slope, "zero_coefficient": 0.0625}),
        EffectSpec("alpha_vane_calibration", {"scale": scale, "offset_deg": 0.0}),
    )
    case = Case(maneuver="diagnostic", turbulence="light", truth_seed=12, effects=effects)
    setting = AnalysisSetting(day_known=True, instruments_known=True, terms=True)
    layout = lay_out(sense(fly(case), "50/50"), aircraft_model("navajo"), setting)
    answer = judge(["flight"], [layout], [theoretical_distribution(layout)])
    (named,) = answer.verdict.effects
    assert named.name == "lift_slope"
    change = named.sizes[0]
    assert change.value == pytest.approx(slope, abs=0.02)
    told = {each.name: each for each in answer.verdict.free}["angle_of_attack scale"]
    assert told.value == pytest.approx(scale, abs=told.two_sigma)
    assert told.two_sigma < 0.03


@pytest.mark.long
def test_a_stiffer_airplane_has_a_sound_vane() -> None:
    """Fitted without the effects beside them, its vane came out 0.4° and 5 % off, and its lift
    slope 7 % too flat.
    """
    stiffer = EffectSpec("pitch_stiffness", {"change": 0.44, "zero_coefficient": 0.0})
    case = Case("c172x", "diagnostic", turbulence="light", truth_seed=12, effects=(stiffer,))
    setting = AnalysisSetting(day_known=True, instruments_known=True, terms=True)
    layout = lay_out(sense(fly(case), "50/50"), aircraft_model("c172x"), setting)
    answer = judge(["flight"], [layout], [theoretical_distribution(layout)])
    assert abs(layout.angles.get("angle_of_attack bias", 0.0)) < BIAS["angle_of_attack"]
    (named,) = answer.verdict.effects
    assert named.name == "pitch_stiffness"
    assert named.sizes[0].value == pytest.approx(0.44, abs=0.02)
