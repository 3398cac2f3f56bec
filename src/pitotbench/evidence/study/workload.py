"""How busy the controls were, and how well the tolerances were kept. Measures, not ratings.

A Cooper-Harper rating is an opinion of a person about a task; nothing here is one.
"""

from dataclasses import dataclass

import numpy as np

from pitotbench.records.flight import Flight
from pitotbench.simulate import MANEUVERS
from pitotbench.units import DEGREE, Array

TRAVEL = {"elevator": 40.0 * DEGREE, "aileron": 40.0 * DEGREE, "throttle_left": 1.0}  # from stop to stop
FELT = 0.02  # of the travel, some millimeters of a yoke: less is no movement of a hand (our estimate)
LOOK_RATE = 10.0  # Hz, ten times what a hand does
_WINDOW = 1.0  # s


@dataclass(frozen=True, slots=True)
class Workload:
    """Of one flight: reversals a minute of each control; share of seconds in which a control moved; share of the
    time that is meant to be on condition spent out of tolerance."""

    reversals: dict[str, float]
    duty: float
    out_of_tolerance: float


def workload(flight: Flight) -> Workload:
    """The workload of a flight from its control positions (elevator, aileron, throttle) and its tolerances."""
    step = max(1, round(len(flight) / flight.duration / LOOK_RATE))
    controls = {name: flight[name][::step] / travel for name, travel in TRAVEL.items()}
    minutes = flight.duration / 60.0
    moved = np.any([_moved(control) for control in controls.values()], axis=0)
    kind = MANEUVERS[flight.case.maneuver].kind
    meant = np.char.startswith(flight.segment[::step], kind)
    return Workload(
        reversals={name: reversals(control) / minutes for name, control in controls.items()},
        duty=float(np.mean(moved)),
        out_of_tolerance=1.0 - float(np.mean(flight.on_condition[::step][meant])),
    )


def reversals(control: Array, felt: float = FELT) -> int:
    """How often a control [share of travel] turns back by more than what is felt."""
    count, direction, extreme = 0, 0, float(control[0])
    for value in control.tolist():
        if direction >= 0 and value < extreme - felt:
            count, direction, extreme = count + (direction > 0), -1, value
        elif direction <= 0 and value > extreme + felt:
            count, direction, extreme = count + (direction < 0), 1, value
        elif (direction >= 0 and value > extreme) or (direction <= 0 and value < extreme):
            extreme = value if direction else extreme
    return count


def _moved(control: Array) -> Array:
    """For each window of a second: whether the control moved by more than what is felt."""
    width = round(_WINDOW * LOOK_RATE)
    windows = control[: len(control) // width * width].reshape(-1, width)
    return np.asarray(np.ptp(windows, axis=1) > FELT)
