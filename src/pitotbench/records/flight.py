"""The truth of a flight. Only simulate makes it and only sense, bench and show may see it."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import cast

import numpy as np
from numpy.typing import NDArray

from pitotbench.records.case import Case
from pitotbench.records.frozen import check_lengths, freeze
from pitotbench.units import Array, Booleans


@dataclass(frozen=True, slots=True)
class Flight:
    """What really happened, at the simulator's rate.

    `channels` maps names of the simulator's property table to arrays of one length (SI, radians);
    `segment` is a label a sample, `on_condition` is true where the card's tolerances are met.
    Raises RecordError where lengths differ.
    """

    case: Case
    channels: Mapping[str, Array]
    segment: NDArray[np.str_]
    on_condition: Booleans

    def __post_init__(self) -> None:
        length = len(self.channels["time"])
        check_lengths("Flight", self.channels.items(), length)
        check_lengths("Flight", [("segment", self.segment), ("on_condition", self.on_condition)], length)
        frozen = {name: cast(Array, freeze(array)) for name, array in self.channels.items()}
        object.__setattr__(self, "channels", MappingProxyType(frozen))
        object.__setattr__(self, "segment", freeze(self.segment))
        object.__setattr__(self, "on_condition", freeze(self.on_condition))

    def __getitem__(self, name: str) -> Array:
        return self.channels[name]

    def __len__(self) -> int:
        return len(self.channels["time"])

    @property
    def duration(self) -> float:
        """Recorded time [s]: set-up between speeds, which is flown but not recorded, does not count."""
        return len(self) * float(np.median(np.diff(self.channels["time"])))
