"""Aircraft of the hangar as models for the analyst: the simulator gives the forces in the states of a log."""

from functools import partial

import numpy as np

from pitotbench.effects import Overlay
from pitotbench.reconcile.residuals.scene import AircraftModel
from pitotbench.records.motion import Motion, Reaction
from pitotbench.simulate.baseline import read_baseline
from pitotbench.simulate.force_meter import FREE, measure
from pitotbench.simulate.fuel_and_ballast import ballast_for, ballast_overlay, loaded_mass
from pitotbench.simulate.hangar import find_aircraft
from pitotbench.simulate.plant import Plant

# Hz. The change of a force by an effect in a held state differs by less than 1 % between the two rates.
COARSE_RATE, FINE_RATE = 25.0, 100.0


def aircraft_model(name: str) -> AircraftModel | None:
    """Return an aircraft of the hangar as the analyst's model; None for `none`. Raises UnknownNameError."""
    if name == "none":
        return None
    return AircraftModel(name, partial(_react, name), read_baseline(find_aircraft(name)))


def _react(name: str, motion: Motion, overlay: Overlay | None = None, engines_run: bool = True) -> Reaction:
    """Return the forces and engine readings of the aircraft in each state of a motion, at the motion's mass."""
    coarse = len(motion.time) > 1 and float(np.median(np.diff(motion.time))) > FREE
    ballast = ballast_for(name, float(motion.mass.min()), float(motion.mass.max()))
    added = (overlay or Overlay()) + ballast_overlay(name, ballast)
    plant = Plant.load(name, COARSE_RATE if coarse else FINE_RATE, added)
    return measure(plant, motion, loaded_mass(name) + ballast, engines_run)
