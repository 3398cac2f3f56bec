"""A flight log: what a measured log holds, and nothing that only a simulator knows."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench.channels import CHANNELS, Recorded
from pitotbench.records.frozen import RecordError, check_lengths, freeze
from pitotbench.timeline import fresh_fixes
from pitotbench.units import Booleans


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightLog(Recorded):
    """One row a sample at the air-data rate; SI and radians; arrays of one length, read-only.

    The channels are those of `channels.Recorded`; optional ones are None where the log lacks them. `header` is
    whatever stood above the table.
    Raises RecordError where lengths differ or time does not increase strictly.
    """

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
        return {name: value for name in CHANNELS if (value := getattr(self, name)) is not None}

    def fresh_fixes(self) -> Booleans:
        """The rows at which the GPS velocity is new: as logged, else found from repeats."""
        return fresh_fixes(self.gps_fresh, self.velocity_north, self.velocity_east)

    def select(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> "FlightLog":
        """The log of the chosen rows (a mask or sorted indices), with the same header."""
        picked = {name: array[rows] for name, array in self.channels().items()}
        return FlightLog(**picked, header=self.header)

    def __len__(self) -> int:
        return len(self.time)
