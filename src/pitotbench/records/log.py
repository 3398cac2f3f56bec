"""A flight log: what a measured log can hold, without anything that only a simulator knows."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench.channels import CHANNELS, Recorded, numbers_from
from pitotbench.records.frozen import RecordError, check_lengths, freeze
from pitotbench.records.shown import Shown
from pitotbench.timeline import fresh_fixes
from pitotbench.units import Booleans


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class FlightLog(Shown, Recorded):
    """A flight log: one row a sample at the air-data rate, in SI and radians; arrays (n,), read-only.

    The channels are those of `channels.Recorded`; an optional channel is None where the log lacks it. `header` is
    the table of entries above the columns of the file.
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
        """Return the channels that are present, by field name."""
        return {name: value for name in CHANNELS if (value := getattr(self, name)) is not None}

    def fresh_fixes(self) -> Booleans:
        """Return whether the GPS velocity is new in each row, (n,): as logged, else found from repeated values."""
        return fresh_fixes(self.gps_fresh, self.velocity_north, self.velocity_east)

    def renewed_fixes(self) -> Booleans:
        """Return whether anything of the GPS is new in each row, (n,): as logged, else found from repeated values.

        On a steady leg a coarse velocity repeats itself while the height goes on; in an outage all stand still.
        """
        present = [values for name in numbers_from("gps") if (values := getattr(self, name)) is not None]
        return fresh_fixes(self.gps_fresh, *present)

    def select(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> "FlightLog":
        """Return the log of some rows (a mask or sorted indices), with the same header."""
        picked = {name: array[rows] for name, array in self.channels().items()}
        return FlightLog(**picked, header=self.header)

    @property
    def simulated(self) -> bool:
        """Whether a simulator made the log: it writes its case into the header, and nothing else does."""
        return "case" in self.header

    def __len__(self) -> int:
        return len(self.time)
