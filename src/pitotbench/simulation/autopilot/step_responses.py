"""Fly the step responses of an aircraft under its autopilot."""

from dataclasses import dataclass

import numpy as np

from pitotbench.records.aircraft import StepResponse
from pitotbench.simulation.pilot import AIRSPEED_HOLD, ALTITUDE_BY_PITCH, BANK_HOLD
from pitotbench.simulation.plant import Plant
from pitotbench.units import DEGREE, FOOT, KNOT

INTERVAL = 0.1  # s between samples
BAND = 0.1  # of the step, within which a response has settled


@dataclass(frozen=True, slots=True)
class StepCommand:
    """A step of a quantity: target, mode, change [SI], unit, and how long it is recorded [s]."""

    quantity: str
    target: str
    mode: tuple[str, float]
    change: float
    unit: str
    factor: float
    seconds: float


STEPS = (
    StepCommand(
        "roll", "bank_target", ("lateral_mode", BANK_HOLD), 20.0 * DEGREE, "°", DEGREE, 15.0
    ),
    StepCommand(
        "altitude",
        "altitude_target",
        ("pitch_mode", ALTITUDE_BY_PITCH),
        100.0 * FOOT,
        "ft",
        FOOT,
        60.0,
    ),
    StepCommand(
        "calibrated_airspeed",
        "airspeed_target",
        ("throttle_mode", AIRSPEED_HOLD),
        5.0 * KNOT,
        "kt",
        KNOT,
        60.0,
    ),
)


def step_responses(aircraft: str, airspeed: float, altitude: float) -> list[StepResponse]:
    """Return the responses of an aircraft at a calibrated airspeed [m/s], each from level flight.

    The airspeed step goes down, so that it needs no power to spare.
    Raises SimulationError where the aircraft does not fly level there.
    """
    return [_flown(aircraft, airspeed, altitude, step) for step in STEPS]


def _flown(aircraft: str, airspeed: float, altitude: float, step: StepCommand) -> StepResponse:
    plant = Plant.load(aircraft)
    plant.start(altitude, airspeed)
    start = {"altitude": altitude, "calibrated_airspeed": airspeed}.get(step.quantity, 0.0)
    before = plant.get(step.quantity)
    change = -step.change if step.quantity == "calibrated_airspeed" else step.change
    plant.set(step.target, start + change)
    plant.set(*step.mode)
    values = [before]
    for _ in range(round(step.seconds / INTERVAL)):
        plant.run(INTERVAL)
        values.append(plant.get(step.quantity))
    moved = np.array(values) - before
    wanted = start + change - before
    outside = np.flatnonzero(np.abs((moved / wanted) - 1.0) > BAND)
    return StepResponse(
        step.quantity,
        step.unit,
        airspeed / KNOT,
        change / step.factor,
        np.linspace(0.0, step.seconds, len(values)),
        moved / step.factor,
        max(0.0, float((moved / wanted).max()) - 1.0),
        float((outside[-1] + 1) * INTERVAL) if len(outside) else 0.0,
    )
