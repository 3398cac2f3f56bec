"""Time series by the names of a log's channels: what an effect on the sensors takes and gives."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from pitotbench.records.errors import BadInputError
from pitotbench.timeline import gaps, interval, stretches
from pitotbench.units import Array, Seconds


@dataclass(frozen=True, slots=True)
class Signals:
    """Channels [SI, radians] over one time base [s] of nearly one rate, in which gaps may lie.

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
        """Raise BadInputError naming the channels that an effect needs and that are missing."""
        missing = [name for name in names if name not in self.channels]
        if missing:
            raise BadInputError(
                f"effect {effect!r} needs the channel{'s' if len(missing) > 1 else ''} {', '.join(missing)}; "
                "record them, or leave the effect out"
            )

    def with_channels(self, **changed: Array) -> "Signals":
        """The signals with some channels replaced."""
        return replace(self, channels={**self.channels, **changed})

    @property
    def interval(self) -> float:
        """The usual time between samples [s]."""
        return interval(self.time)

    def stretches(self) -> list[slice]:
        """The rows of each stretch without a gap."""
        return stretches(self.time, gaps(self.time))
