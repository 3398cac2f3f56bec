"""The change of the reaction by added functions of force, from unit forces: no force meter is needed for it."""

import numpy as np

from pitotbench.effects import EFFECTS, AircraftEffect, Baseline, Overlay
from pitotbench.effects.expression import evaluate, properties_in
from pitotbench.reconcile.residuals.replay import REACTION_NAMES
from pitotbench.records.motion import UnitForces
from pitotbench.units import Array

ADDING = ("DRAG", "SIDE", "ROLL", "PITCH", "YAW")  # not LIFT: functions of drag read the lift, it does not just add


def adds_forces(overlay: Overlay) -> bool:
    """Whether an overlay holds nothing but functions of force that add to those of the aircraft."""
    only = not (overlay.settings or overlay.masses or overlay.forces or overlay.winds or overlay.filters)
    return only and bool(overlay.functions) and all(function.axis in ADDING for function in overlay.functions)


def properties_of_forces(baseline: Baseline) -> frozenset[str]:
    """Return the paths of the aircraft's properties that the functions of all effects read."""
    acting = [e for e in EFFECTS.values() if isinstance(e, AircraftEffect)]
    overlays = [overlay for effect in acting for overlay in effect.fitting(baseline)]
    read = (
        properties_in(function.value) - dict(overlay.sizes).keys()
        for overlay in overlays
        for function in overlay.functions
        if function.axis in ADDING
    )
    return frozenset().union(*read)


def added_forces(overlay: Overlay, units: UnitForces) -> Array:
    """Return the change of the reaction by an overlay of functions, (m, 12). The engines do not answer to it."""
    properties: dict[str, Array | float] = {**units.properties, **dict(overlay.sizes)}
    changes = [
        units.changes[function.axis] * np.reshape(evaluate(function.value, properties), (-1, 1))
        for function in overlay.functions
    ]
    change = np.sum(changes, axis=0)
    engines = np.zeros((len(change), len(REACTION_NAMES) - change.shape[1]))
    return np.concatenate([change, engines], axis=1)
