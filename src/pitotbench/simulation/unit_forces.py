"""Measure the forces of terms, and what a unit of force or moment along each axis changes.

Aerodynamic forces add. The change by any function of force is therefore the sum over the axes of
its value times this unit change, so that one pass over the states serves all effects that add such
functions.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from pitotbench.effects.overlay import ADDING, AxisFunction, Overlay, product, size
from pitotbench.records.motion import AeroTerms, ModelForces, Motion, UnitForces
from pitotbench.simulation.force_meter import CALLS, Rig, read_zero, visit_states
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.variant import on_branch
from pitotbench.timeline import gaps
from pitotbench.units import FOOT, SLUG, Array

LOAD = 100.0  # lb, lb ft: some hundredths of the aircraft's forces, so far above rounding
# s between states in which the changes by a unit are measured: they follow the mass and the angle
# of attack alone
UNIT_STEP = 1.0


# What the air alone does to the airplane, in body axes about its center of gravity [lb, lb ft].
AERO_FORCES = (
    *(f"forces/fb{axis}-aero-lbs" for axis in "xyz"),
    *(f"moments/{axis}-aero-lbsft" for axis in "lmn"),
)
ALPHA_RATE = "aero/alphadot-rad_sec"
UNIT_AXES = ("LIFT", *ADDING)
WING = ("metrics/Sw-sqft", "metrics/bw-ft", "metrics/cbarw-ft")  # area, span and chord


def _path(axis: str) -> str:
    return size("unit_force", axis.lower())


def unit_overlay(axes: Sequence[str] = ADDING) -> Overlay:
    """Return the overlay that this measurement needs: a force of any size along each axis."""
    return Overlay(
        sizes=tuple((_path(axis), 0.0) for axis in axes),
        functions=tuple(AxisFunction(axis, product(_path(axis), 1.0)) for axis in axes),
    )


def _unit_changes(
    plant: Plant, axes: Sequence[str], read: Callable[[], Array], base: Array
) -> Array:
    """Return the change of a reading by a unit of each axis in this state, (a, 6).

    `base` is the value of the reading.
    """
    changes = np.empty((len(axes), 6))
    for change, axis in zip(changes, axes, strict=True):
        path = on_branch(plant.branch, _path(axis))
        plant.set(path, LOAD)
        for _ in range(CALLS):
            plant.run_initial_conditions()
        change[:] = (read() - base) / LOAD
        plant.set(path, 0.0)
    return changes


def measure_terms(
    plant: Plant, motion: Motion, names: Iterable[str], axes: Sequence[str] = UNIT_AXES
) -> AeroTerms:
    """Return a model's aerodynamic forces, and some of its functions, along a measured motion.

    Engines and mass do not matter: the forces are those of the air alone. Parameters: plant,
    freshly loaded with the `unit_overlay` of the axes; motion, the measured states, whose mass is
    not used; names of functions. Raises SimulationError where JSBSim refuses a state or the engines
    do not start.
    """
    rig = Rig.set_up(
        plant, replace(motion, mass=np.full(len(motion.time), plant.get("mass"))), plant.get("mass")
    )
    known = tuple(sorted(names))
    forces = [plant.getter(path)[0] for path in AERO_FORCES]
    reads = [plant.getter(name)[0] for name in (*known, ALPHA_RATE)]
    total, values = np.empty((len(motion.time), 6)), np.empty((len(reads), len(motion.time)))
    units = np.empty((len(axes), len(motion.time), 6))
    for k in range(len(motion.time)):
        for _ in range(CALLS):
            rig.place(k)
        total[k] = [read() for read in forces]
        values[:, k] = [read() for read in reads]
        units[:, k] = _unit_changes(
            plant, axes, lambda: np.array([read() for read in forces]), total[k]
        )
    return AeroTerms(
        total=total,
        units=dict(zip(axes, units, strict=True)),
        values=dict(zip(known, values[:-1], strict=True)),
        alpha_rate=values[-1],
    )


def inertia_of(plant: Plant) -> tuple[float, float, float, float]:
    """Return the moments and product of inertia Ixx, Iyy, Izz and Ixz = ∫xz dm [kg m²].

    The axes are those of the body.

    JSBSim's property `ixz` is an element of the tensor of inertia, and so the negative of the
    product of inertia.
    """
    read = [plant.get(f"inertia/{part}-slugs_ft2") for part in ("ixx", "iyy", "izz", "ixz")]
    ixx, iyy, izz, element = (each * SLUG * FOOT**2 for each in read)
    return ixx, iyy, izz, -element


def measure_forces(plant: Plant, motion: Motion, names: Iterable[str]) -> ModelForces:
    """Return a model's forces, power, weight and inertia along a motion, engines running.

    Parameters: plant, freshly loaded; motion, the measured states, whose mass counts from its first
    state: as much fuel is taken out of the tanks; names of functions, of which those that the model
    has are read. Raises SimulationError where JSBSim refuses a state or the engines do not start.
    """
    plant.run_initial_conditions()  # until then JSBSim's mass lacks the fuel
    loaded = plant.get("mass")
    rig = Rig.set_up(plant, replace(motion, mass=motion.mass - motion.mass[0] + loaded), loaded)
    known = tuple(sorted(name for name in names if plant.serves(name)))
    engines = [path.removesuffix("set-running") for path in plant.engines]
    powers = [f"{path}{kind}" for path in engines for kind in ("thrust-lbs", "power-hp")]
    outside = [path.replace("-aero-", "-external-") for path in AERO_FORCES]
    turned = [path.replace("-aero-", "-prop-") for path in AERO_FORCES[3:]]
    paths = [*AERO_FORCES, *outside, *turned, *powers, *_BODY, *known]
    reads = [plant.getter(path)[0] if plant.serves(path) else read_zero for path in paths]
    rows = np.empty((len(motion.time), len(paths)))
    for k in visit_states(rig, motion, CALLS + 1):
        rows[k] = [read() for read in reads]
    rows[:, 3:6] += rows[:, 12:15]
    engine, body = rows[:, 15 : 15 + len(powers)], rows[:, 15 + len(powers) :]
    return ModelForces(
        air=rows[:, :6] + rows[:, 6:12],
        thrust=engine[:, ::2].sum(axis=1),
        power=engine[:, 1::2].sum(axis=1),
        weight=body[:, 0],
        gravity_center=body[:, 1],
        inertia=body[:, 2:6],
        values=dict(zip(known, body[:, len(_BODY) :].T, strict=True)),
        wing=tuple(plant.get(path) for path in WING),
    )


_BODY = (
    *("inertia/weight-lbs", "inertia/cg-x-in"),
    *(f"inertia/{part}-slugs_ft2" for part in ("ixx", "iyy", "izz", "ixz")),
)


def measure_unit_forces(
    plant: Plant, motion: Motion, loaded_mass: float, paths: Iterable[str]
) -> UnitForces:
    """Return the changes by unit forces along a measured motion, and the properties at `paths`.

    The properties are read in each state: a rate or an angle may change within tenths of a second.
    The changes are measured every `UNIT_STEP` and at both ends of every stretch, and interpolated
    between. The engines are frozen. Parameters and errors are those of `force_meter.measure`; the
    plant has the `unit_overlay`.
    """
    rig = Rig.set_up(plant, motion, loaded_mass)
    names, time = sorted(paths), motion.time
    reads = [plant.getter(name)[0] for name in names]
    values = np.empty((len(names), len(time)))
    measured, found = _in_steps(time), []
    for k in visit_states(rig, motion, CALLS, engines_run=False):
        values[:, k] = [read() for read in reads]
        if k in measured:
            found.append(_unit_changes(plant, ADDING, lambda: rig.row()[:6], rig.row()[:6]))
    at, changes = time[sorted(measured)], np.stack(found, axis=1)
    return UnitForces(
        changes={
            axis: np.stack([np.interp(time, at, each) for each in change.T], axis=1)
            for axis, change in zip(ADDING, changes, strict=True)
        },
        properties=dict(zip(names, values, strict=True)),
    )


def _in_steps(time: Array) -> set[int]:
    """The states every `UNIT_STEP`, and both ends of every stretch."""
    every = max(1, round(UNIT_STEP / float(np.median(np.diff(time))))) if len(time) > 1 else 1
    first = np.array(gaps(time), dtype=int)
    return {*range(0, len(time), every), *first.tolist(), *(first - 1).tolist(), len(time) - 1}
