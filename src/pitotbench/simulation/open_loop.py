"""Fly a maneuver with the measured controls alone: the motion in pitch that the air's forces of a
model make.
"""

import numpy as np

from pitotbench.records.terms import Maneuver
from pitotbench.simulation.force_meter import AERO_FORCES, CALLS, Rig, inertia_of
from pitotbench.simulation.plant import Plant
from pitotbench.units import FOOT, POUND_FORCE, STANDARD_GRAVITY, Array

# The equations of motion in body axes (Klein and Morelli 2006, Aircraft System Identification, eq.
# 3.31) in speed, angle of attack, pitch rate and pitch; sideslip, bank and the other rates are the
# measured ones. The forces of the air are JSBSim's in the state that is reached; thrust, mass and
# inertia are measured. So nothing but the aerodynamic functions of the file decides how the
# airplane answers to the elevator.

_U, _V, _W, _Q, _PITCH = 4, 5, 6, 8, 2  # places in a row of the rig's states


def fly_open_loop(plant: Plant, maneuver: Maneuver, constants: Array) -> tuple[Array, Array]:
    """Return the measured motion and that of a model, (n, 4) each.

    Their columns are true airspeed [m/s], angle of attack [rad], pitch rate [rad/s] and pitch
    [rad].

    `plant` is freshly loaded. `constants` are the drag, lift and pitch-moment coefficients that the
    model lacks in steady flight, (3,); with the measured mean of the forces no model drifts away.
    Heun's method, a step a sample. Raises SimulationError where JSBSim refuses a state.
    """
    motion, count = maneuver.motion, len(maneuver.motion.time)
    mass = plant.get("mass") if maneuver.mass is None else maneuver.mass
    rig = Rig.set_up(plant, motion, float(np.max(mass)))
    forces = [plant.getter(path)[0] for path in AERO_FORCES]
    area, chord = plant.get("metrics/Sw-sqft") * FOOT**2, plant.get("metrics/cbarw-ft") * FOOT
    masses = np.broadcast_to(mass, count)
    thrust = np.zeros(count) if maneuver.thrust is None else maneuver.thrust
    ixx, iyy, izz, ixz = maneuver.inertia or inertia_of(plant)
    given = rig.states.copy()

    def rate(k: int, state: Array) -> Array:
        u, w, q, pitch = state.tolist()
        rig.states[k, [_U, _W, _Q, _PITCH]] = u / FOOT, w / FOOT, q, pitch
        for _ in range(CALLS):
            rig.place(k)
        x, _, z, _, moment, _ = (read() * POUND_FORCE for read in forces)
        pressure = 0.7 * motion.static_pressure[k] * motion.mach[k] ** 2 * area
        alpha = np.arctan2(w, u)
        drag, lift, pitching = constants * pressure
        x += thrust[k] - drag * np.cos(alpha) + lift * np.sin(alpha)
        z -= lift * np.cos(alpha) + drag * np.sin(alpha)
        p, r, v, roll = motion.roll_rate[k], motion.yaw_rate[k], given[k, _V] * FOOT, motion.roll[k]
        moment = moment * FOOT + pitching * chord
        return np.array(
            [
                r * v - q * w + x / masses[k] - STANDARD_GRAVITY * np.sin(pitch),
                q * u - p * v + z / masses[k] + STANDARD_GRAVITY * np.cos(pitch) * np.cos(roll),
                (moment + (izz - ixx) * p * r - ixz * (p**2 - r**2)) / iyy,
                q * np.cos(roll) - r * np.sin(roll),
            ]
        )

    states = np.empty((count, 4))
    states[0] = given[0, _U] * FOOT, given[0, _W] * FOOT, motion.pitch_rate[0], motion.pitch[0]
    for k in range(count - 1):
        step = motion.time[k + 1] - motion.time[k]
        first = rate(k, states[k])
        second = rate(k + 1, states[k] + step * first)
        states[k + 1] = states[k] + 0.5 * step * (first + second)
    measured = np.stack(
        [given[:, _U] * FOOT, given[:, _W] * FOOT, motion.pitch_rate, motion.pitch], axis=1
    )
    return _as_flown(measured, given[:, _V] * FOOT), _as_flown(states, given[:, _V] * FOOT)


def _as_flown(states: Array, sideways: Array) -> Array:
    """States (n, 4) with the components of the airspeed as true airspeed and angle of attack."""
    u, w = states[:, 0], states[:, 1]
    return np.stack(
        [np.sqrt(u**2 + w**2 + sideways**2), np.arctan2(w, u), states[:, 2], states[:, 3]], axis=1
    )
