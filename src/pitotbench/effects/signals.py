"""Time series by the names of a log's channels: the input and the output of an effect on the sensors."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from pitotbench.records.errors import BadInputError
from pitotbench.timeline import gaps, interval, stretches
from pitotbench.units import Array, Seconds


@dataclass(frozen=True, slots=True)
class Signals:
    """Channels [SI, radians], (n,) each, over one time base [s] of nearly constant rate, which may have gaps.

    Names are those of a `FlightLog` (`impact_pressure`, `velocity_north` …); any may be missing.
    Raises BadInputError where lengths differ or time does not increase.
    """

    time: Seconds
    channels: Mapping[str, Array]

    def __post_init__(self) -> None:
        if len(self.time) < 2 or not bool(np.all(np.diff(self.time) > 0.0)):
            raise BadInputError("signals need at least two samples, and time that increases strictly")
        for name, values in self.channels.items():
            if values.shape != self.time.shape:
                raise BadInputError(f"channel {name} has {values.shape} samples, time has {self.time.shape}")
        object.__setattr__(self, "channels", MappingProxyType(dict(self.channels)))

    def __getitem__(self, name: str) -> Array:
        return self.channels[name]

    def __contains__(self, name: str) -> bool:
        return name in self.channels

    def __iter__(self) -> Iterator[str]:
        return iter(self.channels)

    def __len__(self) -> int:
        return len(self.time)

    def require(self, effect: str, names: tuple[str, ...]) -> None:
        """Raise BadInputError that names the channels which an effect needs and which are missing."""
        missing = [name for name in names if name not in self.channels]
        if missing:
            raise BadInputError(
                f"effect {effect!r} needs the channel{'s' if len(missing) > 1 else ''} {', '.join(missing)}; "
                "record them, or leave the effect out"
            )

    def with_channels(self, **changed: Array) -> "Signals":
        """Return the signals with some channels replaced."""
        return replace(self, channels={**self.channels, **changed})

    @property
    def interval(self) -> float:
        """The median time between samples [s]."""
        return interval(self.time)

    def stretches(self) -> list[slice]:
        """Return the rows of each stretch without a gap."""
        return stretches(self.time, gaps(self.time))
