"""An aircraft of the hangar as the analyst's model: what it does in the states of a log."""

from functools import cache, partial

import numpy as np

from pitotbench import air
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
from pitotbench.simulation.properties import PROPERTIES
from pitotbench.simulation.unit_forces import measure_unit_forces, unit_overlay

# Hz. The signatures of effects differ by at most 3 % between 25 and 100 Hz, and by up to 17 % on
# the c310, whose engines need small steps: at 10 Hz they are wrong.
COARSE_RATES, FINE_RATE = (25.0, 50.0), 100.0
SETTLING_TIME = 5.0  # s, of a propeller at constant throttle
SETTLED = 0.01  # change of its speed from step to step, as a share
HEIGHT = 1000.0  # m, at which it is tried


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

    Its mass is the motion's.
    """
    return measure(*_loaded_model(name, motion, overlay or Overlay()), engines_run)


def _unit_forces(name: str, motion: Motion, paths: frozenset[str]) -> UnitForces:
    """Return the changes by unit forces in each state of a motion, and properties at paths."""
    return measure_unit_forces(*_loaded_model(name, motion, unit_overlay()), paths)


def _loaded_model(name: str, motion: Motion, overlay: Overlay) -> tuple[Plant, Motion, float]:
    """Return the aircraft at the rate that a motion needs, the motion, and the mass [kg].

    The mass is the aircraft's with its ballast.
    """
    coarse = len(motion.time) > 1 and float(np.median(np.diff(motion.time))) > FREE
    fastest = float(motion.mach.max() * air.SEA_LEVEL_SOUND_SPEED)
    ballast = ballast_for(name, float(motion.mass.min()), float(motion.mass.max()))
    plant = Plant.load(
        name,
        coarse_rate(name, round(fastest, -1)) if coarse else FINE_RATE,
        overlay + ballast_overlay(name, ballast),
        at_once=True,
    )
    return plant, motion, loaded_mass(name) + ballast


@cache
def coarse_rate(name: str, airspeed: float) -> float:
    """Return the lowest rate [Hz] at which an aircraft's propeller settles at an airspeed [m/s].

    A light propeller overshoots in a long step: its speed then alternates from step to step, and
    the thrust has nothing to do with the throttle.
    """
    return next((rate for rate in COARSE_RATES if _settles(name, rate, airspeed)), FINE_RATE)


def _settles(name: str, rate: float, airspeed: float) -> bool:
    plant = Plant.load(name, rate, at_once=True)
    plant.start_frozen(HEIGHT, airspeed)
    plant.set("throttle_command", 0.5)
    plant.run(SETTLING_TIME)
    path = PROPERTIES["propeller_speed_left"].path
    if not plant.serves(path):
        return True
    before = plant.get(path)
    plant.advance(1)
    return abs(plant.get(path) - before) < SETTLED * max(before, 1.0)
