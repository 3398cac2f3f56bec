"""A flight log: what a measured log holds, and nothing that only a simulator knows."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench.records.frozen import RecordError, check_lengths, freeze
from pitotbench.timeline import fresh_fixes
from pitotbench.units import Array, Booleans, Kelvin, Meters, MetersPerSecond, Pascal, Radians, Seconds


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightLog:
    """One row a sample at the air-data rate; SI and radians; arrays of one length, read-only.

    Optional channels are None where the log lacks them. `header` is whatever stood above the table.
    Raises RecordError where lengths differ or time does not increase strictly.
    """

    time: Seconds
    impact_pressure: Pascal  # indicated: total minus static, as measured
    static_pressure: Pascal  # indicated
    velocity_north: MetersPerSecond
    velocity_east: MetersPerSecond
    velocity_down: MetersPerSecond | None = None
    gps_fresh: Booleans | None = None  # true where the GPS sample is new
    total_temperature: Kelvin | None = None
    air_temperature: Kelvin | None = None
    altitude: Meters | None = None  # geometric
    roll: Radians | None = None
    pitch: Radians | None = None
    heading: Radians | None = None  # true
    roll_rate: Array | None = None
    pitch_rate: Array | None = None
    yaw_rate: Array | None = None
    specific_force_x: Array | None = None
    specific_force_y: Array | None = None
    specific_force_z: Array | None = None
    angle_of_attack: Radians | None = None
    sideslip: Radians | None = None
    throttle_left: Array | None = None
    throttle_right: Array | None = None
    elevator: Radians | None = None
    aileron: Radians | None = None
    rudder: Radians | None = None
    manifold_pressure_left: Pascal | None = None
    manifold_pressure_right: Pascal | None = None
    propeller_speed_left: Array | None = None
    propeller_speed_right: Array | None = None
    fuel_flow_left: Array | None = None
    fuel_flow_right: Array | None = None
    mass: Array | None = None
    segment: NDArray[np.str_] | None = None
    on_condition: Booleans | None = None
    header: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        arrays = self.channels()
        check_lengths("FlightLog", arrays.items(), len(self.time))
        for name, array in arrays.items():
            object.__setattr__(self, name, freeze(array))
        if len(self.time) < 2 or not bool(np.all(np.diff(self.time) > 0.0)):
            raise RecordError("FlightLog.time must hold at least two samples and increase strictly")

    def channels(self) -> dict[str, NDArray[Any]]:
        """The channels that are present, by field name."""
        names = (f.name for f in fields(self) if f.name != "header")
        return {name: value for name in names if (value := getattr(self, name)) is not None}

    def fresh_fixes(self) -> Booleans:
        """The rows at which the GPS velocity is new: as logged, else found from repeats."""
        return fresh_fixes(self.gps_fresh, self.velocity_north, self.velocity_east)

    def select(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> "FlightLog":
        """The log of the chosen rows (a mask or sorted indices), with the same header."""
        picked = {name: array[rows] for name, array in self.channels().items()}
        return FlightLog(**picked, header=self.header)

    def __len__(self) -> int:
        return len(self.time)
