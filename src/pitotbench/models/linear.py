"""Linearize an airplane in level flight with JSBSim, and name its modes of motion."""

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pitotbench.models.performance import CRUISE_HEIGHTS, CRUISE_LEVERS
from pitotbench.models.steady_flight import (
    NOT_FOUND,
    PerformanceModel,
    level_flight,
    stall,
    steady_speeds,
    true_airspeed,
)
from pitotbench.records.linear_model import LinearModel, Mode
from pitotbench.simulation.aircraft_files import SimulationError
from pitotbench.units import FOOT, POUND, Array

# The states of the rigid airplane in JSBSim's names: airspeed, angles of attack, pitch, sideslip
# and bank, and body rates. Position and heading move none of them, but for the air's density by
# height, and JSBSim's linearization moves a propeller's speed at once.
LONGITUDINAL = ("Vt", "Alpha", "Theta", "Q")
STATES = (*LONGITUDINAL, "Beta", "Phi", "P", "R")
# The modes of conventional airplanes, whether they oscillate, and the states that take part most
# (Etkin and Reid, Dynamics of Flight, 3rd edition, 1996, chapter 6).
KINDS = (
    ("short period", True, ("Alpha", "Q")),
    ("phugoid", True, ("Vt", "Theta")),
    ("Dutch roll", True, ("Beta", "R")),
    ("roll", False, ("P",)),
    ("spiral", False, ("Phi",)),
)
COUPLED = 0.1  # share of the states of the other motion, from which on a mode is of both


def linearize(aircraft: str) -> LinearModel:
    """Return the linear model of an aircraft in level flight.

    The aircraft is a name of the hangar or of JSBSim's library, or a path.

    Level flight is the cruise at 8,000 ft and 75 % throttle of the performance table, or the first
    of its other cruises that the aircraft holds. Raises UnknownNameError, BadInputError, or
    SimulationError where it holds none or JSBSim cannot linearize it.
    """
    with TemporaryDirectory(prefix="pitotbench-") as scratch:
        model = PerformanceModel.load(aircraft, Path(scratch))
        trims = (
            level_flight(
                model,
                height,
                lever,
                steady_speeds(model, height, lever, true_airspeed(slow, height)),
            )
            for slow in [stall(model, 0.0, 0.0).calibrated]
            for height, lever in sorted(
                product(CRUISE_HEIGHTS, CRUISE_LEVERS),
                key=lambda cruise: cruise != (CRUISE_HEIGHTS[1], CRUISE_LEVERS[1]),
            )
        )
        trim = None if model.no_engine else next(filter(None, trims), None)
        if trim is None:
            raise SimulationError(
                model.no_engine
                or f"{model.frozen.name}: {NOT_FOUND} that is level, at any height and throttle of "
                "the performance table's cruises"
            )
        found = model.frozen.linearize(trim.state)
        rows = [found.x_names.index(name) for name in STATES]
        system = np.array(found.system_matrix)[np.ix_(rows, rows)]
        return LinearModel(
            aircraft=model.frozen.name,
            mass=model.weight * POUND,
            height=found.x0[found.x_names.index("Alt")] * FOOT,
            calibrated_airspeed=trim.calibrated,
            roll_acceleration=model.frozen.accelerations(trim.state).p,
            states={name: found.x_units[row] for name, row in zip(STATES, rows, strict=True)},
            inputs=dict(zip(found.u_names, found.u_units, strict=True)),
            trim=np.array(found.x0)[rows],
            setting=np.array(found.u0),
            system_matrix=system,
            input_matrix=np.array(found.input_matrix)[rows],
            modes=find_modes(system),
        )


def find_modes(system: Array) -> tuple[Mode, ...]:
    """Return the modes of a system matrix (8, 8) of `STATES`, the fastest first.

    A mode is named by its participation factors: the share of each state in it, which no unit
    changes (Pérez-Arriaga, Verghese and Schweppe, IEEE PAS-101, 1982).
    """
    values, right = np.linalg.eig(system)
    shares = np.abs(right * np.linalg.inv(right).T).T
    return tuple(
        sorted(
            (
                Mode(_name(each.imag > 0.0, dict(zip(STATES, share, strict=True))), each)
                for each, share in zip(values.tolist(), shares, strict=True)
                if each.imag >= 0.0
            ),
            key=lambda mode: -mode.frequency,
        )
    )


def _name(oscillates: bool, shares: Mapping[str, float]) -> str:
    """Return the name of a mode, in which each state has a share of their sum."""
    along = sum(shares[state] for state in LONGITUDINAL) / sum(shares.values())
    name, usual, _ = max(KINDS, key=lambda kind: sum(shares[state] for state in kind[2]))
    return (
        "coupled mode"
        if COUPLED < along < 1.0 - COUPLED
        else name
        if oscillates == usual
        else "mode"
    )
