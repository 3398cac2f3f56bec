"""Measure what a unit of force or moment along each aerodynamic axis changes, in each state of a motion.

Aerodynamic forces add. The change by any function of force is therefore the sum over the axes of its value times
this unit change, so that one pass over the states serves all effects that add such functions.
"""

from collections.abc import Iterable

import numpy as np

from pitotbench.effects import Overlay
from pitotbench.effects.expression import product, size
from pitotbench.effects.overlay import AxisFunction
from pitotbench.records.motion import Motion, UnitForces
from pitotbench.simulate.force_meter import Rig
from pitotbench.simulate.plant import Plant

# Not LIFT: functions of drag may read the lift, so that it does not simply add.
AXES = ("DRAG", "SIDE", "ROLL", "PITCH", "YAW")
LOAD = 100.0  # lb, lb ft: some hundredths of the aircraft's forces, so far above rounding
CALLS = 2  # of JSBSim after a change: the rate of the angle of attack follows the forces of the call before


def _path(axis: str) -> str:
    return size("unit_force", axis.lower())


def unit_overlay() -> Overlay:
    """Return the overlay that a plant needs for this measurement: a force of any size along each axis."""
    return Overlay(
        sizes=tuple((_path(axis), 0.0) for axis in AXES),
        functions=tuple(AxisFunction(axis, product(_path(axis), 1.0)) for axis in AXES),
    )


def measure_unit_forces(plant: Plant, motion: Motion, loaded_mass: float, paths: Iterable[str]) -> UnitForces:
    """Return the changes by unit forces along a measured motion, and the properties at `paths`.

    The engines are held. Parameters and errors are those of `measure`; the plant has the `unit_overlay`.
    """
    rig = Rig.set_up(plant, motion, loaded_mass)
    names = sorted(paths)
    reads = [plant.getter(name)[0] for name in names]
    changes = np.empty((len(AXES), len(motion.time), 6))
    values = np.empty((len(names), len(motion.time)))
    rig.run_in(0)
    for k in range(len(motion.time)):
        for _ in range(CALLS):
            rig.place(k)
        values[:, k] = [read() for read in reads]
        base = rig.row()[:6]
        for i, axis in enumerate(AXES):
            plant.set(_path(axis), LOAD)
            for _ in range(CALLS):
                plant.run_initial_conditions()
            changes[i, k] = (rig.row()[:6] - base) / LOAD
            plant.set(_path(axis), 0.0)
    return UnitForces(
        changes=dict(zip(AXES, changes, strict=True)), properties=dict(zip(names, values, strict=True))
    )
