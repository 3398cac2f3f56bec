"""Shape the loops of the autopilot on linear models of an aircraft, and check them by their steps.

Inner loops come first: pitch rate (proportional and integral, elevator), bank
(aileron), yaw damper (rudder). Each asks for an angular acceleration, which the control
effectiveness at the present airspeed turns into a control position. The outer loops (altitude,
heading, airspeed) are kinematic and the same for all airplanes, and are slowed down where the
inner ones cannot follow. (Stevens, Lewis and Johnson, Aircraft Control and Simulation, 2016, ch.
4.)
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg import block_diag, expm

from pitotbench.simulation.aircraft_files import SimulationError
from pitotbench.simulation.autopilot.linear_model import Linear
from pitotbench.units import KNOT, Array

ACTUATOR = 0.08  # s: lag of actuator, control system and sampling that every loop must bear
PITCH_RATES, PITCH_INTEGRALS = (0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0), (0.5, 1.0, 2.0, 4.0)  # 1/s
MOST_ELEVATOR_GAIN = 3.0  # of the travel a rad/s: more would work the elevator hard in turbulence
DISTURBANCE, UPSET_WEIGHT = 0.05, 20.0  # of the elevator's travel; a radian
LEAST_DAMPING = 0.35  # of any oscillation in a closed loop
FASTEST_BANK, LEAST_ROLL_DAMPING = 1.3, 3.0  # 1/s
YAW_DAMPING, MOST_YAW_GAIN = 0.6, 4.0  # of the Dutch roll; 1/s
CLIMB_GAIN, ALTITUDE_GAIN = 0.7, 0.2  # 1/s
# 1/s; rad and s of lag at the gain: airspeed filter and hand.
SPEED_GAIN, SPEED_PHASE, SPEED_LAGS = 0.14, 0.4, 1.7
LEAST_EFFECT = 0.02  # rad/s² for full travel: below it a control does nothing
SLOWER = 0.8  # times the gain before, until the loop is damped


@dataclass(frozen=True, slots=True)
class Gains:
    """The gains of an aircraft: (trim points,) for inner loops, one number for outer loops."""

    pitch_rate: Array  # 1/s
    pitch_integral: Array  # 1/s
    bank: Array  # 1/s
    roll_rate: Array  # 1/s, added to the roll damping
    yaw_rate: Array  # 1/s, added to the yaw damping
    climb: float  # 1/s
    altitude: float  # 1/s
    speed: float  # 1/s


def shape(name: str, models: Sequence[Linear], engine_time: float) -> Gains:
    """Return the gains of an aircraft from its linear models, slow to fast, and engine lag [s].

    Raises SimulationError, which names the loop and the speed, where a loop cannot be made stable.
    """
    pitch = np.array([_pitch(name, model) for model in models])
    lateral = np.array([_lateral(name, model) for model in models])
    scale = min(
        _altitude_scale(name, model, *gains) for model, gains in zip(models, pitch, strict=True)
    )
    return Gains(
        pitch_rate=pitch[:, 0],
        pitch_integral=pitch[:, 1],
        bank=lateral[:, 0],
        roll_rate=lateral[:, 1],
        yaw_rate=lateral[:, 2],
        climb=scale * CLIMB_GAIN,
        altitude=scale * ALTITUDE_GAIN,
        speed=min(SPEED_GAIN, SPEED_PHASE / (engine_time + SPEED_LAGS)),
    )


def pitch_loop(model: Linear, gain: float, integral: float) -> tuple[Array, Array]:
    """Return the closed pitch-rate loop: its matrix (4, 4) and its input column (4,).

    The states are angle of attack, pitch rate, elevator and integral.
    """
    effect = model.pitch[1, 2]
    a = np.zeros((4, 4))
    a[:2, :2], a[:2, 2] = model.pitch[:, :2], model.pitch[:, 2]
    a[2] = np.array([0.0, -gain / effect, -1.0, gain * integral / effect])
    a[2] /= ACTUATOR
    a[3, 1] = -1.0
    return a, np.array([0.0, 0.0, (gain + pull(model)) / effect / ACTUATOR, 1.0])


def pull(model: Linear) -> float:
    """Return the pitching acceleration of the elevator per unit of a steady pitch rate [1/s]."""
    (lift, _, _), (stiffness, rate, _) = model.pitch
    return max(0.0, float(stiffness / lift - rate)) if lift < 0.0 else 0.0


def bank_loop(model: Linear, bank: float, roll: float, yaw: float) -> tuple[Array, Array]:
    """Return the closed bank loop (beta, p, r, bank, aileron, rudder), and its input column."""
    aileron, rudder = model.lateral[1, 3], model.lateral[2, 4]
    damping = abs(model.lateral[1, 1]) + roll
    alpha, turn = model.trim.alpha, model.gravity
    a = block_diag(np.zeros((4, 4)), -np.eye(2) / ACTUATOR)
    a[:3, :3], a[:3, 4:] = model.lateral[:, :3], model.lateral[:, 3:]
    a[0, 3], a[3, 1] = turn, 1.0
    a[4, [1, 3]] = np.array([-roll, -damping * bank]) / aileron / ACTUATOR
    if has_effect(rudder):
        a[5, [1, 2, 3]] = yaw * np.array([alpha, -1.0, turn]) / rudder / ACTUATOR
    return a, np.array([0.0, 0.0, 0.0, 0.0, damping * bank / aileron / ACTUATOR, 0.0])


def has_effect(effect: float) -> bool:
    """Return whether a control of this effectiveness [rad/s² a full travel] moves the aircraft."""
    return abs(effect) > LEAST_EFFECT


def step_response(a: Array, column: Array, output: int, time: Array) -> Array:
    """Return the response of a state to a unit step, (n,), at even times [s] from zero."""
    size = len(a)
    joined = np.zeros((size + 1, size + 1))
    joined[:size, :size], joined[:size, size] = a, column
    transition = expm(joined * (time[1] - time[0]))
    state = np.append(np.zeros(size), 1.0)
    found = np.empty(len(time))
    for k in range(len(time)):
        found[k] = state[output]
        state = transition @ state
    return found


def damping(a: Array) -> float:
    """Return the least damping ratio of the poles above 0.05 rad/s, -1 where one grows faster."""
    poles = np.linalg.eigvals(a)
    if poles.real.max() > 0.05:  # a slow spiral is held by the outer loops
        return -1.0
    fast = poles[np.abs(poles) > 0.05]
    return float((-fast.real / np.abs(fast)).min(initial=1.0))


_TIME = np.linspace(0.0, 6.0, 121)


def _pitch(name: str, model: Linear) -> tuple[float, float]:
    if not has_effect(model.pitch[1, 2]):
        raise SimulationError(f"{name}: the elevator does nothing at {_knots(model)}")
    best, chosen = np.inf, None
    for gain, integral in product(PITCH_RATES, PITCH_INTEGRALS):
        a, column = pitch_loop(model, gain, integral)
        if gain > MOST_ELEVATOR_GAIN * abs(model.pitch[1, 2]) or damping(a) < LEAST_DAMPING:
            continue
        response = step_response(a, column, 1, _TIME)
        # The attitude lost [rad] to a disturbance counts as well: an airplane out of trim drifts
        # off its height.
        upset = step_response(
            a, np.array([0.0, DISTURBANCE * model.pitch[1, 2], 0.0, 0.0]), 3, _TIME
        )
        cost = float(np.abs(1.0 - response).mean() + max(0.0, response.max() - 1.15))
        cost += UPSET_WEIGHT * float(np.abs(upset).mean())
        if cost < best:
            best, chosen = cost, (gain, integral)
    if chosen is None:
        raise SimulationError(f"{name}: no pitch-rate loop is stable at {_knots(model)}")
    return chosen


def _lateral(name: str, model: Linear) -> tuple[float, float, float]:
    if not has_effect(model.lateral[1, 3]):
        raise SimulationError(f"{name}: the ailerons do nothing at {_knots(model)}")
    side, roll_damping, yaw_damping = (abs(model.lateral[i, i]) for i in range(3))
    roll = max(0.2 * roll_damping, LEAST_ROLL_DAMPING - roll_damping)
    stiffness = max(model.lateral[2, 0], 0.0)
    yaw = float(
        np.clip(2.0 * YAW_DAMPING * stiffness**0.5 - yaw_damping - side, 0.3, MOST_YAW_GAIN)
    )
    bank = FASTEST_BANK
    while bank > 0.2:
        for damper in (yaw, 0.5 * yaw, 0.0):
            a, column = bank_loop(model, bank, roll, damper)
            if damping(a) >= 0.6 * LEAST_DAMPING and step_response(a, column, 3, _TIME).max() < 1.3:
                return bank, roll, damper
        bank *= SLOWER
    raise SimulationError(f"{name}: no bank loop is stable at {_knots(model)}")


def _altitude_scale(name: str, model: Linear, gain: float, integral: float) -> float:
    """Return the factor on climb and altitude gains that leaves the altitude loop well damped.

    Raises SimulationError where none does.
    """
    inner, column = pitch_loop(model, gain, integral)
    speed, scale = model.trim.speed, 1.0
    while scale > 0.1:
        a = np.zeros((6, 6))
        a[:4, :4] = inner
        a[4, 1] = 1.0
        a[5, 4], a[5, 0] = speed, -speed
        wanted = np.zeros(6)  # pitch rate wanted, by the states
        wanted[4], wanted[0] = -scale * CLIMB_GAIN, scale * CLIMB_GAIN
        wanted[5] = -(scale**2) * CLIMB_GAIN * ALTITUDE_GAIN / speed
        a[:4] += np.outer(column, wanted)
        if damping(a) >= LEAST_DAMPING:
            return scale
        scale *= SLOWER
    raise SimulationError(f"{name}: no altitude loop is stable at {_knots(model)}")


def _knots(model: Linear) -> str:
    return f"{model.trim.calibrated / KNOT:.0f} KCAS"
