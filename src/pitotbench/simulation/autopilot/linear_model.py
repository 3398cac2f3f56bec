"""Linearize an aircraft about a trim point by finite differences of its accelerations."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos

import numpy as np

from pitotbench.simulation.autopilot.envelope import Trim
from pitotbench.simulation.autopilot.frozen_aircraft import FrozenAircraft, State
from pitotbench.units import DEGREE, KNOT, STANDARD_GRAVITY, Array

# Half widths of the central differences.
DIFFERENCES = {
    "alpha": 0.5 * DEGREE,
    "beta": 1.0 * DEGREE,
    "roll_rate": 0.05,
    "pitch_rate": 0.03,
    "yaw_rate": 0.03,
    "elevator": 0.1,
    "aileron": 0.1,
    "rudder": 0.1,
}
STEP_TIME, LARGEST_TIME = 0.1, 8.0  # s
ENGINE_STEP = 0.1  # of the lever


@dataclass(frozen=True, slots=True)
class Linear:
    """The linear models of an aircraft at a trim point.

    `pitch` is (2, 3): the rates of angle of attack [rad/s] and of pitch rate [rad/s²] by angle of
    attack, pitch rate and elevator. `lateral` is (3, 5): those of sideslip, roll rate and yaw rate
    by sideslip, roll rate, yaw rate, aileron and rudder. `gravity` [1/s] is the rate of sideslip a
    radian of bank. Controls go from -1 to 1.
    """

    trim: Trim
    pitch: Array
    lateral: Array
    gravity: float


def linearize(aircraft: FrozenAircraft, trim: Trim) -> Linear:
    """Return the linear models at a trim point, the flight control system included."""
    base = State(trim.speed, trim.alpha, elevator=trim.elevator)
    aircraft.place(base)
    aircraft.set_lever(trim.lever)

    def by(name: str) -> Array:
        sides = []
        for sign in (1.0, -1.0):
            state = replace(base, **{name: getattr(base, name) + sign * DIFFERENCES[name]})
            found = aircraft.accelerations(state)
            sides.append(
                (
                    found.normal(state.alpha) / trim.speed,
                    found.q,
                    found.v / trim.speed,
                    found.p,
                    found.r,
                )
            )
        slopes: Array = (np.array(sides[0]) - np.array(sides[1])) / (2.0 * DIFFERENCES[name])
        return slopes

    pitch = np.stack([by(name)[:2] for name in ("alpha", "pitch_rate", "elevator")], axis=1)
    names = ("beta", "roll_rate", "yaw_rate", "aileron", "rudder")
    lateral = np.stack([by(name)[2:] for name in names], axis=1)
    return Linear(trim, pitch, lateral, STANDARD_GRAVITY * cos(trim.alpha) / trim.speed)


# What a model with a slope of the wrong sign does, in the order of `wrong_slopes`.
WRONG = (
    "the pitching moment rises with the angle of attack",
    "the yawing moment falls with sideslip",
    "the rolling moment rises with sideslip",
    "the pitching moment rises with the pitch rate",
    "the rolling moment rises with the roll rate",
    "the yawing moment rises with the yaw rate",
)
SLIGHT = 0.001  # rad/s² a radian or a rad/s: a smaller slope is none


def wrong_slopes(aircraft: FrozenAircraft, models: Sequence[Linear]) -> list[str]:
    """Return a sentence for each slope of a moment whose sign makes the airplane unstable.

    The moments are about the body axes; a sentence has the calibrated airspeeds. Sideslip is
    positive with wind from the right.
    """
    ixx, izz, ixz = (aircraft.read(f"inertia/{part}-slugs_ft2") for part in ("ixx", "izz", "ixz"))
    stable = []
    for model in models:
        # Moments over moments of inertia; JSBSim's ixz is the negative of the product of inertia.
        roll = model.lateral[1] + ixz / ixx * model.lateral[2]
        yaw = model.lateral[2] + ixz / izz * model.lateral[1]
        alpha, rate = model.pitch[1, :2]
        stable.append([-alpha, yaw[0], -roll[0], -rate, -roll[1], -yaw[2]])
    wrong = np.array(stable) < -SLIGHT
    speeds = np.array([f"{model.trim.calibrated / KNOT:.0f}" for model in models])
    return [
        f"{words} at {', '.join(speeds[at])} KCAS"
        for words, at in zip(WRONG, wrong.T, strict=True)
        if at.any()
    ]


def engine_time(aircraft: FrozenAircraft, trim: Trim) -> float:
    """Return the time [s] in which the thrust makes 63 % of its change after a lever step."""
    aircraft.place(State(trim.speed, trim.alpha, elevator=trim.elevator))
    lever = min(trim.lever, 1.0 - ENGINE_STEP)
    before = aircraft.set_lever(lever)
    after = aircraft.set_lever(lever + ENGINE_STEP)
    aircraft.set_lever(lever)
    aircraft.move_lever(lever + ENGINE_STEP)
    for sample in range(1, round(LARGEST_TIME / STEP_TIME)):
        aircraft.run(STEP_TIME * 100.0)
        if abs(aircraft.thrust() - before) >= 0.63 * abs(after - before):
            return sample * STEP_TIME
    return LARGEST_TIME
