"""Where the velocity through the air points, from attitude and flow angles."""

import numpy as np

from pitotbench.records.errors import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.units import Array


def air_direction(log: FlightLog) -> Array:
    """Unit vector of the velocity through the air, north, east, down, (3, n), from attitude and flow angles.

    Raises BadInputError where the log lacks one of them.
    """
    needed = {"roll": log.roll, "pitch": log.pitch, "heading": log.heading}
    flow = {"angle_of_attack": log.angle_of_attack, "sideslip": log.sideslip}
    missing = [name for name, value in (needed | flow).items() if value is None]
    if log.roll is None or log.pitch is None or log.heading is None or missing:
        raise BadInputError(f"the vector form needs attitude and flow angles; the log lacks {', '.join(missing)}")
    assert log.angle_of_attack is not None
    assert log.sideslip is not None
    x = np.cos(log.angle_of_attack) * np.cos(log.sideslip)
    y = np.sin(log.sideslip)
    z = np.sin(log.angle_of_attack) * np.cos(log.sideslip)
    across = y * np.cos(log.roll) - z * np.sin(log.roll)
    below = y * np.sin(log.roll) + z * np.cos(log.roll)
    ahead = x * np.cos(log.pitch) + below * np.sin(log.pitch)
    return np.stack(
        [
            ahead * np.cos(log.heading) - across * np.sin(log.heading),
            ahead * np.sin(log.heading) + across * np.cos(log.heading),
            below * np.cos(log.pitch) - x * np.sin(log.pitch),
        ]
    )
