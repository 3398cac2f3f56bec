"""Turn vectors between body axes (forward, right, down) and earth axes (north, east, down).

A vector keeps its unit; angles are radians. Source:
Stevens and Lewis, Aircraft Control and Simulation, 2003, §1.3 (attitude) and §2.3 (flow angles).
"""

import numpy as np

from pitotbench.units import Array, Radians


def body_to_earth(vector: Array, roll: Radians, pitch: Radians, heading: Radians) -> Array:
    """Turn vectors, (3, n), from body axes to earth axes, (3, n).

    Angles are in radians, (n,); heading is true.
    """
    # One rotation after the other, in reverse order of the Euler angles: roll, then pitch, then
    # heading.
    forward, right, down = vector
    (sin_roll, sin_pitch, sin_heading), (cos_roll, cos_pitch, cos_heading) = (
        [wave(angle) for angle in (roll, pitch, heading)] for wave in (np.sin, np.cos)
    )
    level_right = right * cos_roll - down * sin_roll
    below = right * sin_roll + down * cos_roll
    level_forward = forward * cos_pitch + below * sin_pitch
    return np.stack(
        [
            level_forward * cos_heading - level_right * sin_heading,
            level_forward * sin_heading + level_right * cos_heading,
            below * cos_pitch - forward * sin_pitch,
        ]
    )


def earth_to_body(vector: Array, roll: Radians, pitch: Radians, heading: Radians) -> Array:
    """Turn vectors, (3, n), from earth axes to body axes, (3, n): inverse of `body_to_earth`."""
    from scipy.spatial.transform import Rotation  # slow to load, and needed without vanes alone

    attitude = Rotation.from_euler("ZYX", np.stack([heading, pitch, roll], axis=1))
    return np.asarray(attitude.apply(vector.T, inverse=True).T)


def flow_direction(angle_of_attack: Radians, sideslip: Radians) -> Array:
    """Return the direction of flow angles in body axes, as unit vectors (3, n)."""
    level = np.cos(sideslip)
    return np.stack(
        [np.cos(angle_of_attack) * level, np.sin(sideslip), np.sin(angle_of_attack) * level]
    )


def euler_rates(
    roll_rate: Array, pitch_rate: Array, yaw_rate: Array, roll: Radians, pitch: Radians
) -> tuple[Array, Array, Array]:
    """Return the rates of roll, pitch and heading of body rates, (n,) each, in the unit of these.

    At a pitch of 90° no finite ones exist.
    """
    turning = pitch_rate * np.sin(roll) + yaw_rate * np.cos(roll)
    return (
        roll_rate + turning * np.tan(pitch),
        pitch_rate * np.cos(roll) - yaw_rate * np.sin(roll),
        turning / np.cos(pitch),
    )


def body_rates(
    rolling: Array, pitching: Array, turning: Array, roll: Radians, pitch: Radians
) -> tuple[Array, Array, Array]:
    """Return the body rates of rates of roll, pitch and heading: the inverse of `euler_rates`."""
    level = turning * np.cos(pitch)
    return (
        rolling - turning * np.sin(pitch),
        pitching * np.cos(roll) + level * np.sin(roll),
        level * np.cos(roll) - pitching * np.sin(roll),
    )
