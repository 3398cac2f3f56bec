"""Measure how much the controls moved, and how well the tolerances were kept.

These are measures and not ratings: a Cooper-Harper rating is the opinion of a pilot about a task.
"""

from dataclasses import dataclass

import numpy as np

from pitotbench.records.flight import Flight
from pitotbench.simulate import MANEUVERS
from pitotbench.units import DEGREE, Array

TRAVEL = {"elevator": 40.0 * DEGREE, "aileron": 40.0 * DEGREE, "throttle_left": 1.0}  # from stop to stop
FELT = 0.02  # of the travel, some millimeters of a yoke: a smaller change is no hand movement (our estimate)
LOOK_RATE = 10.0  # Hz, ten times the rate of hand movements
_WINDOW = 1.0  # s


@dataclass(frozen=True, slots=True)
class Workload:
    """The workload of one flight.

    It is the number of reversals a minute of each control, the share of seconds in which a control moved, and the
    share of the time to be flown on condition that was out of tolerance.
    """

    reversals: dict[str, float]
    duty: float
    out_of_tolerance: float


def workload(flight: Flight) -> Workload:
    """Return the workload of a flight, from its control positions (elevator, aileron, throttle) and tolerances."""
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
    """Return how often a control [share of travel] reverses by more than `felt`."""
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
    """Return for each window of one second whether the control moved by more than `FELT`."""
    width = round(_WINDOW * LOOK_RATE)
    windows = control[: len(control) // width * width].reshape(-1, width)
    return np.asarray(np.ptp(windows, axis=1) > FELT)
