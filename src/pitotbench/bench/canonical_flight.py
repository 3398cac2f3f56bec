"""A short flight in light turbulence that tells whether two machines fly alike."""

from pitotbench.records.case import Case
from pitotbench.simulate import fly
from pitotbench.units import Array

# The shortest card that a calibration can use: half a minute of a decelerating turn.
SHORTEST_CARD = {"speeds_kt": [130.0, 110.0], "dwells_s": [10.0, 10.0], "settle_s": 2.0}
CANONICAL = Case(maneuver="decel_circle", card=SHORTEST_CARD, turbulence="light", truth_seed=1)
_CHANNELS = ("total_pressure", "static_pressure", "air_temperature", "velocity_north", "velocity_east")


def canonical_channels() -> dict[str, Array]:
    """Fly the canonical flight and return the channels that are compared, (n,) each [SI]."""
    flight = fly(CANONICAL)
    return {name: flight[name] for name in _CHANNELS}
