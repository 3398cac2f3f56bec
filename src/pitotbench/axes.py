"""Turn vectors between body axes (forward, right, down) and earth axes (north, east, down).

A vector keeps its unit; angles are radians. Source:
Stevens and Lewis, Aircraft Control and Simulation, 2003, §1.3 (attitude) and §2.3 (flow angles).
"""

import numpy as np

from pitotbench.units import Array, Radians


def body_to_earth(vector: Array, roll: Radians, pitch: Radians, heading: Radians) -> Array:
    """Turn vectors, (3, n), from body axes to earth axes, (3, n). Angles are in radians, (n,);
    heading is true.
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
    """Turn vectors, (3, n), from earth axes to body axes, (3, n): the inverse of `body_to_earth`."""
    from scipy.spatial.transform import Rotation  # slow to load, and needed without vanes alone

    attitude = Rotation.from_euler("ZYX", np.stack([heading, pitch, roll], axis=1))
    return np.asarray(attitude.apply(vector.T, inverse=True).T)


def flow_direction(angle_of_attack: Radians, sideslip: Radians) -> Array:
    """Return the direction of the velocity through the air in body axes, unit vectors (3, n), from
    flow angles.
    """
    level = np.cos(sideslip)
    return np.stack(
        [np.cos(angle_of_attack) * level, np.sin(sideslip), np.sin(angle_of_attack) * level]
    )
