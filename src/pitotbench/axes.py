"""Axes: body (forward, right, down through the airplane) and earth (north, east, down).

Stevens and Lewis, Aircraft Control and Simulation, 2003, §1.3 (attitude) and §2.3 (flow angles).
"""

import numpy as np

from pitotbench.units import Array, Radians


def body_to_earth(vector: Array, roll: Radians, pitch: Radians, heading: Radians) -> Array:
    """Turn vectors from body axes (forward, right, down) to earth axes (north, east, down), both (3, n)."""
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
    """Unit vector of the velocity through the air in body axes, (3, n), from the flow angles."""
    return np.stack(
        [
            np.cos(angle_of_attack) * np.cos(sideslip),
            np.sin(sideslip),
            np.sin(angle_of_attack) * np.cos(sideslip),
        ]
    )
