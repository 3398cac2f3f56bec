"""The forces of the air alone, as the model of maneuvers, and the maneuvers of a file.

What an engine does in a maneuver is measured or free: the model's thrust, which depends on the
seconds before, stays out. Mass and inertia are measured, else the model's.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from pitotbench.effects.overlay import ADDING, Overlay
from pitotbench.models.aircraft_model import FINE_RATE
from pitotbench.models.maneuver_parts import align_vane
from pitotbench.reconciliation.residuals import AircraftModel
from pitotbench.records.maneuver import Maneuver, Maneuvers
from pitotbench.records.motion import Motion, Reaction, UnitForces
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.baseline import read_baseline
from pitotbench.simulation.modified import loaded_mass, patch_errors, patched_mass
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.unit_forces import inertia_of, measure_terms, unit_overlay
from pitotbench.units import FOOT, POUND_FORCE, Array

LEAST_RATE = 1e-4  # rad/s of the angle of attack from which a function over its rate is scaled
MOST_RATIO = 5.0  # of the measured rate over the model's


def air_model(name: str, maneuvers: Sequence[Maneuver]) -> AircraftModel:
    """Return an aircraft of the hangar as the maneuvers' model, with inertia stated or its own.

    Raises UnknownNameError.
    """
    inertia = next((each.inertia for each in maneuvers if each.inertia), None)
    baseline = read_baseline(find_aircraft(name))
    rated = {f.name: f.axis for f in baseline.functions if f.axis and f.variable == "alpha_rate"}
    ixx, iyy, izz, ixz = inertia or inertia_of(_weighed(name))
    tensor = np.array([[ixx, 0.0, -ixz], [0.0, iyy, 0.0], [-ixz, 0.0, izz]])
    added = patched_mass(name)
    react = partial(_react, name, tensor, added, rated)
    units = partial(_unit_forces, name, tensor, added)
    return AircraftModel(name, react, units, baseline, loaded_mass(name), (), patch_errors(name))


def _weighed(name: str) -> Plant:
    """An aircraft with its mass and inertia."""
    plant = Plant.load(name, FINE_RATE, at_once=True)
    plant.run_initial_conditions()  # until then JSBSim's mass lacks the fuel
    return plant


def _react(
    name: str,
    inertia: Array,
    added: float,
    rated: dict[str, str],
    motion: Motion,
    overlay: Overlay | None = None,
    engines_run: bool = False,
) -> Reaction:
    """Return the specific forces and angular accelerations that the air makes in each state.

    The mass is the measured one and what a patch has `added` to it [kg]. A function over the rate
    of the angle of attack follows the model's own forces; that of the log is measured.
    """
    axes = sorted(set(rated.values()))
    plant = Plant.load(name, FINE_RATE, unit_overlay(axes) + (overlay or Overlay()), at_once=True)
    found = measure_terms(plant, motion, rated, axes)
    rate = np.gradient(np.unwrap(motion.angle_of_attack), motion.time)
    slow = np.abs(found.alpha_rate) <= LEAST_RATE
    ratio = np.where(slow, 1.0, rate / np.where(slow, 1.0, found.alpha_rate))
    force = found.total.copy()
    for function, axis in rated.items():
        more = found.values[function] * (np.clip(ratio, -MOST_RATIO, MOST_RATIO) - 1.0)
        force += found.units[axis] * more[:, None]
    rates = np.stack([motion.roll_rate, motion.pitch_rate, motion.yaw_rate], axis=1)
    turning = -np.cross(rates, rates @ inertia) @ np.linalg.inv(inertia)
    made = _accelerations(force, motion.mass + added, inertia)
    made[:, 3:] += turning
    none = np.zeros((len(made), len(Reaction.__dataclass_fields__) - made.shape[1]))
    columns = np.concatenate([made, none], axis=1).T
    return Reaction(**dict(zip(Reaction.__dataclass_fields__, columns, strict=True)))


def _accelerations(force: Array, mass: Array, inertia: Array) -> Array:
    """Specific forces and angular accelerations, (n, 6), by forces [lb] and moments [lb ft]."""
    linear = force[:, :3] * POUND_FORCE / mass[:, None]
    turning = force[:, 3:] * POUND_FORCE * FOOT @ np.linalg.inv(inertia)
    return np.concatenate([linear, turning], axis=1)


def _unit_forces(
    name: str, inertia: Array, added: float, motion: Motion, paths: frozenset[str]
) -> UnitForces:
    plant = Plant.load(name, FINE_RATE, unit_overlay(ADDING), at_once=True)
    found = measure_terms(plant, motion, paths, ADDING)
    changes = {a: _accelerations(u, motion.mass + added, inertia) for a, u in found.units.items()}
    return UnitForces(changes=changes, properties=found.values)


def in_place_of_log(maneuvers: Sequence[Maneuver], aircraft: str) -> Maneuvers:
    """Return maneuvers with the vane in time, and with the measured mass or the aircraft's.

    Raises UnknownNameError.
    """
    aligned, lag = align_vane(maneuvers)
    mass = loaded_mass(aircraft)
    weighed = (
        replace(each, motion=replace(each.motion, mass=np.full(len(each.motion.time), mass)))
        if each.mass is None
        else replace(each, motion=replace(each.motion, mass=each.mass))
        for each in aligned
    )
    return Maneuvers(tuple(weighed), {"warnings": tuple(_remarks(maneuvers, lag))})


def _remarks(maneuvers: Sequence[Maneuver], lag: float) -> list[str]:
    """What was corrected, and what was assumed because the logs lack it."""
    remarks = (
        [f"The angle-of-attack vane lags by {lag:.2f} s; it was taken earlier."] if lag else []
    )
    if any(each.thrust is None for each in maneuvers):
        remarks.append("Thrust was not measured: the drag is left out.")
    if any(each.mass is None for each in maneuvers):
        remarks.append(
            "Mass was not measured: it is the model's, and its error is one of every force."
        )
    if any("side force" not in each.channels for each in maneuvers):
        remarks.append("Sideslip was not measured: side force, roll and yaw are left out.")
    remarks.append(
        "A wrong scale of the angle-of-attack vane would change lift slope and pitch stiffness by "
        "the same share: it is not excluded."
    )
    return remarks
