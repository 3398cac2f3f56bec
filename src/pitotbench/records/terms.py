"""Aerodynamic terms: a measured maneuver with its forces, and what it says about each term of a
model.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pitotbench.records import check_lengths, freeze
from pitotbench.records.aircraft import Motion
from pitotbench.records.calibration import Estimate
from pitotbench.units import Array

SIGNIFICANT = 1.5  # times the noise, from which a channel shows a gap
CHANNELS = ("drag", "side force", "lift", "roll moment", "pitch moment", "yaw moment")


@dataclass(frozen=True, slots=True)
class Maneuver:
    """A maneuver with what was felt in it; arrays (n,) in SI units and radians, body axes.

    `specific_force` (n, 3) [m/s²] and `angular_acceleration` (n, 3) [rad/s²] are measured. `thrust`
    [N] is that of all engines along the body's x axis; None where it was not measured. `mass` [kg]
    and `inertia` (I_xx, I_yy, I_zz, I_xz) [kg m²] are None where those of the model count.
    `channels` are those of `CHANNELS` that the log can show: without a measured sideslip, not those
    of side force, roll and yaw. `noise` are the deviations of the errors left in fields of the
    motion that change from sample to sample, in their units. Raises RecordError where lengths
    differ.
    """

    name: str
    motion: Motion
    specific_force: Array
    angular_acceleration: Array
    thrust: Array | None = None
    mass: Array | None = None
    inertia: tuple[float, ...] | None = None
    channels: tuple[str, ...] = CHANNELS
    noise: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        arrays = {
            name: value
            for name in ("specific_force", "angular_acceleration", "thrust", "mass")
            if (value := getattr(self, name)) is not None
        }
        columns = (
            (name, column)
            for name, each in arrays.items()
            for column in np.atleast_2d(np.transpose(each))
        )
        check_lengths("Maneuver", columns, len(self.motion.time))
        for name, array in arrays.items():
            object.__setattr__(self, name, freeze(np.asarray(array, dtype=np.float64)))


@dataclass(frozen=True, slots=True)
class TermEstimate:
    """One aerodynamic term of a model's file beside the flight.

    `name` is the field's, `function` that of the file, `channel` one of `CHANNELS`. `model` and
    `measured` are the coefficient in `unit`; `change` is the relative change of the function, with
    its bound. `closes` is the share of the explainable gap that the term closes beyond those before
    it. `like` are terms that it cannot be told from.
    """

    name: str
    function: str
    axis: str
    channel: str
    unit: str
    model: float
    measured: Estimate
    change: Estimate
    closes: float
    like: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ChannelGap:
    """The sums of squares of a channel in the unit of its noise, per sample.

    `before` is that of the model, `after` that with the terms, `noise` what no term of the file
    explains.
    """

    before: float
    after: float
    noise: float

    @property
    def significant(self) -> bool:
        """Whether the model leaves clearly more than the noise."""
        return self.before > SIGNIFICANT * self.noise

    @property
    def closed(self) -> float:
        """The share of the explainable gap that the terms close."""
        explainable = self.before - self.noise
        return (self.before - self.after) / explainable if explainable > 0.0 else 0.0


@dataclass(frozen=True, slots=True)
class ManeuverGap:
    """The gap of one maneuver by channel; `held_out` says that no size was fitted to it.

    `time` [s] counts from its begin, (n,). `before` and `after` are the residual forces [N] and
    moments [N m], (n, 6), without the constants of the maneuver. `constants` are these as
    coefficients of drag, lift and pitch moment, before and with the terms, (2, 3).
    """

    name: str
    held_out: bool
    channels: Mapping[str, ChannelGap]
    time: Array
    before: Array
    after: Array
    constants: Array


# The motions of an open-loop flight: heading, name and unit of each, as a person reads them.
MOTIONS = (("airspeed", "kt"), ("angle of attack", "°"), ("pitch rate", "°/s"), ("pitch", "°"))


@dataclass(frozen=True, slots=True)
class OpenLoopFlight:
    """A maneuver flown by a model with the measured controls: true airspeed [m/s], then angles and
    rate [rad].

    `time` [s] counts from its begin, (n,); the others are (n, 4), in the order of `MOTIONS`.
    """

    name: str
    held_out: bool
    time: Array
    measured: Array
    before: Array
    after: Array


@dataclass(frozen=True, slots=True)
class TermsAccount:
    """What measured maneuvers say about the aerodynamic terms of a model.

    `terms` come in the order of what they close. `silent` names, with the reason, what the
    maneuvers cannot show. `zeros` are the coefficients added to changed slopes, by function, so
    that they turn about the flown angle.
    """

    aircraft: str
    terms: tuple[TermEstimate, ...]
    maneuvers: tuple[ManeuverGap, ...]
    silent: tuple[str, ...]
    zeros: Mapping[str, float]
    remarks: tuple[str, ...] = ()
    flown: tuple[OpenLoopFlight, ...] = ()

    @property
    def fitted(self) -> "TermsAccount":
        """The account on the maneuvers that were fitted alone; itself where none was held out."""
        own = tuple(each for each in self.maneuvers if not each.held_out)
        return self if len(own) in (0, len(self.maneuvers)) else replace(self, maneuvers=own)

    @property
    def held_out(self) -> tuple[ManeuverGap, ...]:
        """The maneuvers to which no size was fitted; all of them where none was held out."""
        return tuple(each for each in self.maneuvers if each.held_out) or self.maneuvers

    def gap_of(self, channel: str) -> ChannelGap:
        """The gap of a channel over the maneuvers held out, each sample with the same weight."""
        found = [
            (each.channels[channel], len(each.time))
            for each in self.held_out
            if channel in each.channels
        ]
        weights = np.array([count for _, count in found], dtype=np.float64)
        sums = [[gap.before, gap.after, gap.noise] for gap, _ in found]
        return ChannelGap(*(weights @ np.array(sums) / weights.sum()).tolist())

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels that a maneuver held out shows."""
        return tuple(
            name for name in CHANNELS if any(name in each.channels for each in self.held_out)
        )

    @property
    def closed(self) -> float:
        """The share of the explainable gap that the terms close, over all channels with a
        significant gap.
        """
        gaps = [gap for name in self.channels if (gap := self.gap_of(name)).significant]
        explainable = sum(gap.before - gap.noise for gap in gaps)
        return (
            sum(gap.before - gap.after for gap in gaps) / explainable if explainable > 0.0 else 0.0
        )
