"""What an effect is: a name, where it acts, its sizes with units and plausible ranges, and its source."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from pitotbench.effects.excitation import Excitation
from pitotbench.effects.overlay import Baseline, Overlay
from pitotbench.effects.signals import Signals
from pitotbench.units import Array

Family = Literal["pneumatic", "das", "air", "airframe", "propulsion"]
ActsOn = Literal["sensors", "air", "aircraft"]
Sizes = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of an effect; the name ends in its unit (none where it has no dimension).

    0 means no effect and is always allowed besides `low` to `high`. A `shape` (a time, a damping) says how the
    effect looks, not how large it is: it may be left out and then is `typical`.
    """

    name: str
    typical: float
    low: float
    high: float
    what: str
    shape: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """What all effects share.

    `shows_in` says what to fly so that the effect shows best. `variant_of` names the effect of which this is
    another form of the same cause (a second-order line for a lag). An effect on the sensors changes the channels
    `changes`, and `also` where there are such; no others.
    """

    name: str
    family: Family
    acts_on: ActsOn
    parameters: tuple[Parameter, ...]
    source: str
    what: str
    shows_in: Excitation
    variant_of: str = ""
    changes: tuple[str, ...] = ()
    also: tuple[str, ...] = ()

    @property
    def cause(self) -> str:
        """The name of the effect of which this is a form, else its own: a second-order line and a lag have one
        cause."""
        return self.variant_of or self.name

    def parameter(self, name: str) -> Parameter:
        """A parameter by its name. Raises StopIteration for one that the effect lacks."""
        return next(p for p in self.parameters if p.name == name)

    def complete(self, sizes: Sizes) -> dict[str, float]:
        """The sizes with `typical` for each shape left out and 0 for each size left out."""
        default = {p.name: p.typical if p.shape else 0.0 for p in self.parameters}
        return {**default, **sizes}

    def is_off(self, sizes: Sizes) -> bool:
        """Whether all sizes (shapes apart) are zero: such an effect is none."""
        full = self.complete(sizes)
        return all(full[p.name] == 0.0 for p in self.parameters if not p.shape)

    def typical(self) -> dict[str, float]:
        """Every parameter at its typical value."""
        return {p.name: p.typical for p in self.parameters}


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorEffect(Effect):
    """An effect between the air and the log: a function of time series that a measured log could hold.

    `needs` are the channels it reads. It acts on what the probes feel, before noise and sampling, or with
    `after_noise` on the samples as the recorder would store them.
    """

    function: Callable[[Signals, Mapping[str, float]], Signals]
    needs: tuple[str, ...] = ()
    after_noise: bool = False

    def apply(self, signals: Signals, sizes: Sizes) -> Signals:
        """The signals with the effect in them; the very same ones at zero size.

        Raises BadInputError naming a channel that it needs and the signals lack.
        """
        if self.is_off(sizes):
            return signals
        signals.require(self.name, (*self.needs, *self.changes))
        return self.function(signals, self.complete(sizes))


@dataclass(frozen=True, slots=True, kw_only=True)
class AircraftEffect(Effect):
    """An effect in the airframe or the powerplant: data that JSBSim loads on top of the untouched aircraft."""

    build: Callable[[Mapping[str, float], Baseline], Overlay]

    def overlay(self, sizes: Sizes, baseline: Baseline) -> Overlay:
        """What to put on an aircraft; nothing at zero size.

        Raises BadInputError where the aircraft lacks what the effect changes.
        """
        return Overlay() if self.is_off(sizes) else self.build(self.complete(sizes), baseline)


@dataclass(frozen=True, slots=True, kw_only=True)
class AirEffect(AircraftEffect):
    """An effect in the air that JSBSim flies through: wind in time and space, turbulence, temperature.

    `wind(signals, sizes)` is the same wind toward north, east and down [m/s] over the time and altitude of a log,
    where it does not depend on chance.
    """

    wind: Callable[[Signals, Mapping[str, float]], tuple[Array, Array, Array]] | None = None
