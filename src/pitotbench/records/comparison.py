"""Two versions of a model compared along one flown motion."""

from collections.abc import Mapping
from dataclasses import dataclass

from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class ChannelChange:
    """A channel's root mean square and largest change [`unit`] in a phase of a flown motion.

    `share` is the largest change over the channel's largest value in the whole motion,
    `coefficient` the root mean square as a coefficient; None where the channel has none. `growth`
    is the share by which the channel is larger at every instant alike; None where it is not.
    """

    channel: str
    phase: str
    unit: str
    change: float
    largest: float
    share: float
    coefficient: float | None
    growth: float | None = None


@dataclass(frozen=True, slots=True)
class TermChange:
    """One difference between two files, and what it alone changes in flight.

    `name` is the field's, `part` that of the file. `old` and `new` are the coefficient or the
    number [`unit`], None where the part holds none. `effects` are its changes by channel, each over
    the whole motion, the largest share first; it is empty for a difference without an effect.
    """

    name: str
    part: str
    unit: str
    old: float | None
    new: float | None
    effects: tuple[ChannelChange, ...]


@dataclass(frozen=True, slots=True)
class FlownChange:
    """A figure of steady flight of the old and of the new airplane [`unit`]."""

    name: str
    condition: str
    unit: str
    old: float
    new: float


@dataclass(frozen=True, slots=True)
class ModelComparison:
    """What changed in flight between two files of an airplane, along a motion of the old one.

    `time` [s] is that of the motion, (n,), and `traces` the change of each channel that changed,
    (n,). `located` holds the phases of each channel. `remarks` say what the terms do not add up to.
    `flown` are the figures of steady flight; () where nothing changes in flight.
    """

    old: str
    new: str
    card: str
    time: Array
    traces: Mapping[str, Array]
    channels: tuple[ChannelChange, ...]
    located: tuple[ChannelChange, ...]
    terms: tuple[TermChange, ...]
    remarks: tuple[str, ...] = ()
    flown: tuple[FlownChange, ...] = ()

    @property
    def largest(self) -> float:
        """The largest change of any channel, as a share of the channel's largest value."""
        return max((each.share for each in self.channels), default=0.0)
