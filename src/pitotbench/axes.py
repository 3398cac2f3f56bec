"""Turn vectors between body axes (forward, right, down) and earth axes (north, east, down).

A vector keeps its unit; angles are radians. Source:
Stevens and Lewis, Aircraft Control and Simulation, 2003, §1.3 (attitude) and §2.3 (flow angles).
"""

import numpy as np

from pitotbench.units import Array, Radians


def body_to_earth(vector: Array, roll: Radians, pitch: Radians, heading: Radians) -> Array:
    """Turn vectors, (3, n), from body axes to earth axes, (3, n). Angles are in radians, (n,); heading is true."""
    # One rotation after the other, in reverse order of the Euler angles: roll, then pitch, then heading.
    forward, right, down = vector
    level_right = right * np.cos(roll) - down * np.sin(roll)
    below = right * np.sin(roll) + down * np.cos(roll)
    level_forward = forward * np.cos(pitch) + below * np.sin(pitch)
    return np.stack(
        [
            level_forward * np.cos(heading) - level_right * np.sin(heading),
            level_forward * np.sin(heading) + level_right * np.cos(heading),
            below * np.cos(pitch) - forward * np.sin(pitch),
        ]
    )


def flow_direction(angle_of_attack: Radians, sideslip: Radians) -> Array:
    """Return the direction of the velocity through the air in body axes, unit vectors (3, n), from flow angles."""
    return np.stack(
        [
            np.cos(angle_of_attack) * np.cos(sideslip),
            np.sin(sideslip),
            np.sin(angle_of_attack) * np.cos(sideslip),
        ]
    )
