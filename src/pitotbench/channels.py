"""The table of channels: everything that a flight log can hold, one line a channel.

A line states the type, the unit, the instrument, the plausible range, and the noise and resolution
of the simulated sensor. The log record, the columns of log files, the checks on reading, the
simulated sensors and the reconciliation all read this table. A new channel is one line here and, to
be simulated, one line in `simulation/properties.py`.
"""

from dataclasses import dataclass, replace
from math import pi
from typing import Annotated, Literal, get_type_hints

import numpy as np
from numpy.typing import NDArray

from pitotbench.units import (
    INCH_OF_MERCURY,
    POUND,
    SUFFIXES,
    Array,
    Booleans,
    Kelvin,
    Meters,
    MetersPerSecond,
    Pascal,
    Radians,
    Seconds,
)

Source = Literal["clock", "air", "gps", "inertial", "vane", "control", "engine", "weight", "label"]

_ANY = float("inf")
_QUARTER, _TURN = 0.5 * pi, 2.0 * pi  # rad


@dataclass(frozen=True, slots=True)
class Channel:
    """One channel of a log. In the table, `name` is the name of its field.

    `unit` is the canonical unit suffix, "" for a plain number. `source` is the instrument: all
    channels of one source get new values together.

    `low` and `high` [SI] are the plausible range: the median of |x| is at least `low`, the 95 %
    quantile of |x| at most `high`. Outside it the unit is wrong or the sensor is dead. For an
    `essential` channel this is an error; any other channel is then ignored, with a warning.

    `noise` (1σ of the white noise) and `resolution` describe the simulated sensor: a number [SI],
    or the name of the field of `DataSystem` that holds it. `noise` is None for channels that the
    recorder computes in another way. `wraps` marks an angle that starts again at a full turn.
    """

    unit: str
    source: Source
    low: float
    high: float
    noise: str | float | None = None
    resolution: str | float = 0.0
    essential: bool = False
    wraps: bool = False
    kind: Literal["number", "flag", "text"] = "number"
    name: str = ""

    @property
    def column(self) -> str:
        """The canonical column name."""
        return f"{self.name}_{self.unit}" if self.unit else self.name

    @property
    def suffixes(self) -> list[str]:
        """The unit suffixes that a column of this channel may end in."""
        return [
            s
            for s, u in SUFFIXES.items()
            if self.unit and u.dimension == SUFFIXES[self.unit].dimension
        ]


# Entries that several channels share. The upper limits allow for fast jets and for short peaks; the
# lower ones exclude a sensor that is switched off, and the most common wrong units.
_VELOCITY = Channel(
    "mps", "gps", 0.0, 700.0, "velocity_noise", "velocity_resolution", essential=True
)
_RATE = Channel("radps", "inertial", 0.0, 10.0, "rate_noise", 1e-4)
_SPECIFIC_FORCE = Channel("mps2", "inertial", 0.0, 100.0, "acceleration_noise", 1e-3)
_VANE = Channel("rad", "vane", 0.0, _QUARTER, "vane_noise", 1e-4)
_THROTTLE = Channel("", "control", 0.0, 1.1, 0.002, 1e-4)  # position potentiometer: 0.2 % of travel
_SURFACE = Channel("rad", "control", 0.0, _QUARTER, 0.001, 1e-4)  # 0.06°
_MANIFOLD_PRESSURE = Channel("pa", "engine", 5e3, 400e3, 0.05 * INCH_OF_MERCURY, 5.0)
_PROPELLER_SPEED = Channel("radps", "engine", 0.0, 1000.0, 0.2, 0.01)  # 2 rpm
_FUEL_FLOW = Channel("kgps", "engine", 0.0, 3.0, 0.5 * POUND / 3600.0, 1e-6)  # half a pound an hour


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorded:
    """The channels of a log as typed fields.

    `records.log.FlightLog` adds the header and the checks.

    Each resolution that is a number is a twentieth of the noise or finer: too fine to matter, but
    coarse enough to keep log files short.
    """

    time: Annotated[Seconds, Channel("s", "clock", 0.0, _ANY, essential=True)]
    # Air data are indicated, as measured; the impact pressure is total minus static.
    impact_pressure: Annotated[Pascal, Channel("pa", "air", 0.0, 150e3, essential=True)]
    static_pressure: Annotated[Pascal, Channel("pa", "air", 5e3, 120e3, essential=True)]
    velocity_north: Annotated[MetersPerSecond, _VELOCITY]
    velocity_east: Annotated[MetersPerSecond, _VELOCITY]
    velocity_down: Annotated[
        MetersPerSecond | None, replace(_VELOCITY, high=300.0, essential=False)
    ] = None
    # True where the GPS sample is new.
    gps_fresh: Annotated[Booleans | None, Channel("", "gps", 0.0, 1.0, kind="flag")] = None
    total_temperature: Annotated[
        Kelvin | None, Channel("k", "air", 180.0, 450.0, essential=True)
    ] = None
    air_temperature: Annotated[Kelvin | None, Channel("k", "air", 180.0, 335.0, essential=True)] = (
        None
    )
    # Geometric.
    altitude: Annotated[Meters | None, Channel("m", "gps", 0.0, 25e3, "altitude_noise", 0.01)] = (
        None
    )
    roll: Annotated[
        Radians | None, Channel("rad", "inertial", 0.0, _TURN, "attitude_noise", 1e-4)
    ] = None
    pitch: Annotated[
        Radians | None, Channel("rad", "inertial", 0.0, _QUARTER, "attitude_noise", 1e-4)
    ] = None
    # True, from 0 to a turn; the range allows for noise at its end.
    heading: Annotated[
        Radians | None,
        Channel("rad", "inertial", 0.0, 1.005 * _TURN, "attitude_noise", 1e-4, wraps=True),
    ] = None
    roll_rate: Annotated[Array | None, _RATE] = None
    pitch_rate: Annotated[Array | None, _RATE] = None
    yaw_rate: Annotated[Array | None, _RATE] = None
    # In body axes: forward, right, down. An airplane in flight is hardly ever near weightless for
    # long.
    specific_force_x: Annotated[Array | None, _SPECIFIC_FORCE] = None
    specific_force_y: Annotated[Array | None, _SPECIFIC_FORCE] = None
    specific_force_z: Annotated[Array | None, replace(_SPECIFIC_FORCE, low=3.0)] = None
    angle_of_attack: Annotated[Radians | None, _VANE] = None
    sideslip: Annotated[Radians | None, _VANE] = None
    throttle_left: Annotated[Array | None, _THROTTLE] = None
    throttle_right: Annotated[Array | None, _THROTTLE] = None
    elevator: Annotated[Radians | None, _SURFACE] = None
    aileron: Annotated[Radians | None, _SURFACE] = None
    rudder: Annotated[Radians | None, _SURFACE] = None
    manifold_pressure_left: Annotated[Pascal | None, _MANIFOLD_PRESSURE] = None
    manifold_pressure_right: Annotated[Pascal | None, _MANIFOLD_PRESSURE] = None
    propeller_speed_left: Annotated[Array | None, _PROPELLER_SPEED] = None
    propeller_speed_right: Annotated[Array | None, _PROPELLER_SPEED] = None
    fuel_flow_left: Annotated[Array | None, _FUEL_FLOW] = None
    fuel_flow_right: Annotated[Array | None, _FUEL_FLOW] = None
    # Weighed before flight less the fuel used: no noise, but a word length.
    mass: Annotated[Array | None, Channel("kg", "weight", 0.1, 700e3, 0.0, 0.1)] = None
    segment: Annotated[NDArray[np.str_] | None, Channel("", "label", 0.0, 0.0, kind="text")] = None
    on_condition: Annotated[Booleans | None, Channel("", "label", 0.0, 1.0, kind="flag")] = None


CHANNELS: dict[str, Channel] = {
    name: replace(hint.__metadata__[-1], name=name)
    for name, hint in get_type_hints(Recorded, include_extras=True).items()
}


def numbers_from(source: Source) -> tuple[str, ...]:
    """Return the names of a source's channels of numbers, in the order of the table."""
    return tuple(c.name for c in CHANNELS.values() if c.source == source and c.kind == "number")
