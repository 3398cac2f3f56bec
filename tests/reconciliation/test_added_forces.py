"""Functions of force evaluated along the states change the reaction as the force meter says."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench.bench.null_flights import aircraft_model
from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import AircraftEffect
from pitotbench.effects.overlay import Overlay, evaluate, operation, product, properties_in, quotient, total
from pitotbench.reconciliation.residuals import AircraftModel
from pitotbench.reconciliation.track import (
    added_forces,
    adds_forces,
    answer,
    motion_of,
    properties_of_forces,
    track_of,
)
from pitotbench.records.aircraft import Motion, UnitForces
from pitotbench.units import Array

SAME = 1e-6  # of the largest change: the rate of the angle of attack is that of the call before
Measured = tuple[AircraftModel, Motion, Array, UnitForces]


@pytest.fixture(scope="module")
def measured(sensed) -> Measured:
    log = sensed(das="50/50")
    track = track_of(log.select(log.time < log.time[0] + 25.0))
    motion = motion_of(track, np.arange(0, len(track.time), 50))
    # Banked and at a high lift, so that every effect of the table shows.
    motion = replace(motion, roll=motion.roll + 0.5, angle_of_attack=motion.angle_of_attack + 0.08)
    model = aircraft_model("navajo")
    units = model.unit_forces(motion, Overlay(), properties_of_forces(model.baseline))
    return model, motion, answer(lambda m: model.react(m, Overlay(), False), motion), units


def sizes_of_forces() -> list[tuple[str, str]]:
    """Every size of the table that adds functions of force alone."""
    model = aircraft_model("navajo")
    aircraft = [e for e in EFFECTS.values() if isinstance(e, AircraftEffect)]
    sizes = [(e, p) for e in aircraft for p in e.parameters if not p.shape]
    return [
        (e.name, p.name)
        for e, p in sizes
        if adds_forces(e.overlay(e.complete({p.name: p.typical}), model.baseline))
    ]


def test_most_effects_of_the_airframe_add_forces() -> None:
    assert {"belly_pod", "induced_drag", "polar_bend", "trim_offset", "turn_drag"} <= dict(sizes_of_forces()).keys()


@pytest.mark.parametrize(("name", "parameter"), sizes_of_forces())
def test_added_forces_are_those_of_the_force_meter(measured: Measured, name: str, parameter: str) -> None:
    model, motion, held, units = measured
    effect = EFFECTS[name]
    sizes = {p.name: 1.7 * p.typical for p in effect.parameters if p.shape or p.name == parameter}
    overlay = effect.overlay(effect.complete(sizes), model.baseline)
    on_meter = answer(lambda m: model.react(m, overlay, False), motion) - held
    assert np.abs(on_meter).max() > 3e-4  # m/s², rad/s²: far above rounding
    assert np.allclose(added_forces(overlay, units), on_meter, rtol=0.0, atol=SAME * np.abs(on_meter).max())


@pytest.mark.parametrize(
    ("name", "size"),
    [("control_effectiveness", "elevator_change"), ("flap_not_up", "extension"), ("mass", "mass_kg")],
)
def test_forces_that_are_not_plain_additions_stay_on_the_force_meter(name: str, size: str) -> None:
    model, effect = aircraft_model("navajo"), EFFECTS[name]
    assert not adds_forces(effect.overlay(effect.complete({size: 0.1}), model.baseline))


def test_expression_has_the_values_that_its_operations_say() -> None:
    x = np.array([0.5, 2.0])
    nested = operation("max", 0.0, operation("difference", operation("sqrt", "a/x"), 1.0))
    assert properties_in(nested) == {"a/x"}
    assert evaluate(nested, {"a/x": x}) == pytest.approx([0.0, np.sqrt(2.0) - 1.0])
    share = quotient(total(1.0, product(2.0, "a/x")), "b")
    assert evaluate(share, {"a/x": x, "b": 4.0}) == pytest.approx([0.5, 1.25])
    with pytest.raises(KeyError):
        evaluate("<tan><value>1.0</value></tan>", {})


@pytest.mark.parametrize(("name", "column"), [("belly_pod", 0), ("flap_not_up", 2)])
def test_held_engines_fall_out_of_the_difference(sensed, name: str, column: int) -> None:
    log = sensed(das="50/50")
    track = track_of(log.select(log.time < log.time[0] + 25.0))
    motion = motion_of(track, np.arange(0, len(track.time), 50))
    model, effect = aircraft_model("navajo"), EFFECTS[name]
    overlay = effect.overlay(effect.typical(), model.baseline)
    changes = [
        answer(lambda m, run=run: model.react(m, overlay, run), motion)
        - answer(lambda m, run=run: model.react(m, Overlay(), run), motion)
        for run in (True, False)
    ]
    running, held = (change[:, column] for change in changes)
    assert np.abs(running).max() > 0.01
    assert np.allclose(held, running, rtol=0.02, atol=0.01 * np.abs(running).max())
