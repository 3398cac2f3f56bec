"""The direction of the velocity through the air, from attitude and flow angles."""

from pitotbench.axes import body_to_earth, flow_direction
from pitotbench.records.errors import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.units import Array


def air_direction(log: FlightLog) -> Array:
    """Return the unit vector of the velocity through the air, north, east, down, (3, n).

    Raises BadInputError where the log lacks attitude or a flow angle.
    """
    attitude = {"roll": log.roll, "pitch": log.pitch, "heading": log.heading}
    angles = {"angle_of_attack": log.angle_of_attack, "sideslip": log.sideslip}
    missing = [name for name, value in (attitude | angles).items() if value is None]
    if log.roll is None or log.pitch is None or log.heading is None or missing:
        raise BadInputError(f"the vector form needs attitude and flow angles; the log lacks {', '.join(missing)}")
    assert log.angle_of_attack is not None
    assert log.sideslip is not None
    flow = flow_direction(log.angle_of_attack, log.sideslip)
    return body_to_earth(flow, log.roll, log.pitch, log.heading)
