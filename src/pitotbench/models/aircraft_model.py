"""An aircraft of the hangar as the analyst's model: what it does in the states of a log."""

from functools import partial

import numpy as np

from pitotbench.effects.overlay import Overlay
from pitotbench.effects.propulsion import THROTTLE_RIGGING
from pitotbench.reconciliation.residuals import AircraftModel
from pitotbench.records.motion import CONTROLS, Motion, Reaction, UnitForces
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.aircraft_files import read_record
from pitotbench.simulation.baseline import read_baseline
from pitotbench.simulation.force_meter import FREE, measure
from pitotbench.simulation.modified import (
    ballast_for,
    ballast_overlay,
    loaded_mass,
    patch_errors,
    patched_sizes,
)
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.unit_forces import measure_unit_forces, unit_overlay

# Hz. The signatures of effects differ by at most 3 % between the two rates, and by up to 17 % on
# the c310, whose engines need small steps: at 10 Hz they are wrong.
COARSE_RATE, FINE_RATE = 25.0, 100.0


def aircraft_model(name: str) -> AircraftModel | None:
    """Return an aircraft of the hangar as the analyst's model; None for `none`.

    Raises UnknownNameError.
    """
    if name == "none":
        return None
    folder = find_aircraft(name)
    record = read_record(folder)
    # An aircraft may have one engine. Its surfaces it has, even where their positions are not
    # served.
    missing = set(record.missing if record is not None else ()) & {
        "throttle_left",
        "throttle_right",
    }
    controls = tuple(control for control in CONTROLS if control not in missing)
    react, unit_forces = partial(_react, name), partial(_unit_forces, name)
    baseline, errors, rigged = read_baseline(folder), patch_errors(name), patched_sizes(name)
    left, right = (rigged.get((THROTTLE_RIGGING.name, side), 0.0) for side in ("left", "right"))
    return AircraftModel(
        name, react, unit_forces, baseline, loaded_mass(name), controls, errors, left - right
    )


def _react(
    name: str, motion: Motion, overlay: Overlay | None = None, engines_run: bool = True
) -> Reaction:
    """Return the forces and engine readings of the aircraft in each state of a motion.

    The mass is the motion's.
    """
    return measure(*_loaded_model(name, motion, overlay or Overlay()), engines_run)


def _unit_forces(name: str, motion: Motion, paths: frozenset[str]) -> UnitForces:
    """Return the changes by unit forces in each state of a motion, and the properties at the paths."""
    return measure_unit_forces(*_loaded_model(name, motion, unit_overlay()), paths)


def _loaded_model(name: str, motion: Motion, overlay: Overlay) -> tuple[Plant, Motion, float]:
    """Return the aircraft at the rate that a motion needs, the motion, and a mass [kg].

    The mass is the aircraft's with its ballast.
    """
    coarse = len(motion.time) > 1 and float(np.median(np.diff(motion.time))) > FREE
    ballast = ballast_for(name, float(motion.mass.min()), float(motion.mass.max()))
    plant = Plant.load(
        name,
        COARSE_RATE if coarse else FINE_RATE,
        overlay + ballast_overlay(name, ballast),
        at_once=True,
    )
    return plant, motion, loaded_mass(name) + ballast
