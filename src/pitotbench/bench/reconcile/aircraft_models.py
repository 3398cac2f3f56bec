"""Aircraft of the hangar as models for the analyst: the simulator gives the forces in the states of a log."""

from functools import partial

import numpy as np

from pitotbench.effects import Overlay
from pitotbench.reconcile.residuals.scene import AircraftModel
from pitotbench.records.errors import BadInputError
from pitotbench.records.motion import Motion, Reaction, UnitForces
from pitotbench.simulate.attach.record import read_record
from pitotbench.simulate.baseline import read_baseline
from pitotbench.simulate.force_meter import FREE, measure
from pitotbench.simulate.fuel_and_ballast import ballast_for, ballast_overlay, loaded_mass
from pitotbench.simulate.hangar import find_aircraft
from pitotbench.simulate.plant import Plant
from pitotbench.simulate.unit_forces import measure_unit_forces, unit_overlay

# Hz. The change of a force by an effect in a held state differs by less than 1 % between the two rates.
COARSE_RATE, FINE_RATE = 25.0, 100.0
_MOST_NAMED = 3  # missing channels in an error


def aircraft_model(name: str) -> AircraftModel | None:
    """Return an aircraft of the hangar as the analyst's model; None for `none`. Raises UnknownNameError.

    Raises BadInputError for an aircraft without the channels of a twin with pistons, which the analysis needs.
    """
    if name == "none":
        return None
    folder = find_aircraft(name)
    record = read_record(folder)
    if record is not None and record.missing:
        more = f" and {len(record.missing) - _MOST_NAMED} more" if len(record.missing) > _MOST_NAMED else ""
        raise BadInputError(
            f"{name}: reconcile drives both engines and all surfaces of a model from the log, and this one has no "
            f"{', '.join(record.missing[:_MOST_NAMED])}{more}; use --aircraft none to judge the sensors alone"
        )
    return AircraftModel(name, partial(_react, name), partial(_unit_forces, name), read_baseline(folder))


def _react(name: str, motion: Motion, overlay: Overlay | None = None, engines_run: bool = True) -> Reaction:
    """Return the forces and engine readings of the aircraft in each state of a motion, at the motion's mass."""
    return measure(*_loaded(name, motion, overlay or Overlay()), engines_run)


def _unit_forces(name: str, motion: Motion, overlay: Overlay, paths: frozenset[str]) -> UnitForces:
    """Return the changes by unit forces in each state of a motion, and the properties at the paths."""
    return measure_unit_forces(*_loaded(name, motion, overlay + unit_overlay()), paths)


def _loaded(name: str, motion: Motion, overlay: Overlay) -> tuple[Plant, Motion, float]:
    """The aircraft at the rate that a motion needs, the motion, and the aircraft's mass with its ballast [kg]."""
    coarse = len(motion.time) > 1 and float(np.median(np.diff(motion.time))) > FREE
    ballast = ballast_for(name, float(motion.mass.min()), float(motion.mass.max()))
    plant = Plant.load(name, COARSE_RATE if coarse else FINE_RATE, overlay + ballast_overlay(name, ballast))
    return plant, motion, loaded_mass(name) + ballast
