"""The truth of a flight, and the errors of a calibration against it.

Package `simulation` makes the truth; only `sensing`, `bench` and `show` may use it."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import cast

import numpy as np
from numpy.typing import NDArray

from pitotbench.records import check_lengths, freeze, freeze_arrays
from pitotbench.records.case import Case
from pitotbench.units import Array, Booleans


@dataclass(frozen=True, slots=True)
class Flight:
    """The truth of one flight, at the simulator's rate.

    `channels` maps names of the simulator's property table to arrays, (n,) each [SI, radians].
    `segment` is a label for each sample, `on_condition` is true where the card's tolerances are
    met, (n,) both. `unlisted_mass` [kg] is that of the aircraft's patches, which its weight sheet
    lacks. Raises RecordError where lengths differ.
    """

    case: Case
    channels: Mapping[str, Array]
    segment: NDArray[np.str_]
    on_condition: Booleans
    unlisted_mass: float = 0.0

    def __post_init__(self) -> None:
        length = len(self.channels["time"])
        check_lengths("Flight", self.channels.items(), length)
        frozen = {name: cast(Array, freeze(array)) for name, array in self.channels.items()}
        object.__setattr__(self, "channels", MappingProxyType(frozen))
        freeze_arrays(self, length)

    def __getitem__(self, name: str) -> Array:
        return self.channels[name]

    def __len__(self) -> int:
        return len(self.channels["time"])

    @property
    def duration(self) -> float:
        """The recorded time [s], without the set-ups between speeds, which are flown unrecorded."""
        return len(self) * self._step

    @property
    def elapsed(self) -> float:
        """The time [s] from the first recorded sample through the last, with what lies between.

        What is not recorded between them counts as well.
        """
        # In whole steps, as the recorded time: where nothing is left out both are one number.
        return (round(float(np.ptp(self.channels["time"])) / self._step) + 1) * self._step

    @property
    def _step(self) -> float:
        """The time [s] that a sample stands for."""
        return float(np.median(np.diff(self.channels["time"])))


@dataclass(frozen=True, slots=True)
class Score:
    """Errors against the truth, over the scored airspeed range.

    Speeds in m/s; `curve_coverage` is the share of curve points inside 2σ, `on_condition_share`
    that of the flight's samples on condition, `minutes` the recorded time, `samples` the number of
    rows fitted.
    """

    minutes: float
    samples: int
    residual_two_sigma: float
    two_sigma: float
    curve_rms_error: float
    wind_error: float
    curve_coverage: float
    on_condition_share: float
