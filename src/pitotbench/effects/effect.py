"""The records of an effect: where it acts, its parameters with units and ranges, its source, and what shows it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

from pitotbench.effects.overlay import Baseline, Overlay, size
from pitotbench.effects.response import Signals
from pitotbench.records import BadInputError
from pitotbench.units import Array

# Say what to fly so that an effect shows: the motions that excite it, and the maneuvers that contain them.


@dataclass(frozen=True, slots=True)
class Excitation:
    """A way of flying that makes an effect show.

    `maneuvers` are names of the table of maneuvers, the best one first. `text` describes the flying in words.
    """

    maneuvers: tuple[str, ...]
    text: str

    def __str__(self) -> str:
        return f"{self.text} ({', '.join(self.maneuvers)})"


CHANGING_AIRSPEED = Excitation(
    ("rapid_decel",), "idle decelerations on opposite headings, and the acceleration between them"
)

CHANGING_HEIGHT = Excitation(("diagnostic",), "a climb and a descent at constant airspeed")
TURNING = Excitation(("circle", "figure_eight"), "full circles at 30° of bank to one side, or at 45° to both")
SIDESLIP = Excitation(("diagnostic",), "steady-heading sideslips to both sides")
POWER = Excitation(("diagnostic",), "one airspeed with high and low power, in a climb and a descent")
RANGE_OF_AIRSPEED = Excitation(("four_leg",), "level flight from the highest to the lowest airspeed")

STEPS_OF_AIRSPEED = Excitation(
    ("step_decrease", "step_both_ways"), "level flight in small steps of airspeed, both ways"
)

STEADY_LEGS = Excitation(("race_track",), "long level legs at constant airspeed and power")
EARLY_AND_LATE = Excitation(("race_track",), "the same airspeeds early and late in one long log")

TEMPERATURE = Excitation(
    ("race_track",),
    "legs on reciprocal headings at the highest and lowest airspeed, with a balloon's temperature",
)


# The records of an effect: its name, where it acts, its parameters with units and ranges, and its source.

Family = Literal["pneumatic", "das", "air", "airframe", "propulsion"]
ActsOn = Literal["sensors", "air", "aircraft"]
Sizes = Mapping[str, float]
SensorFunction = Callable[[Signals, Sizes], Signals]


def reads(channel: str, read: Callable[[Array, Sizes], Array]) -> SensorFunction:
    """Return the function of a wrong reading of one channel: `read` turns true values, (n,), into those read."""
    return lambda signals, sizes: signals.with_channels(**{channel: read(signals[channel], sizes)})


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of an effect. Its name ends in its unit; a number without dimension has no unit.

    A size lies between `low` and `high`; zero means no effect and is always allowed. A `shape`, such as a time or a
    damping, says how the effect looks, not how large it is: a case may omit it, and then it is `typical`. A size
    that `may_be_missing` is 0 where a case omits it. Without a size that is `defining` the effect would be another
    one of the table: a line with water in it, but no water, is a line that is late.
    """

    name: str
    typical: float
    low: float
    high: float
    what: str
    shape: bool = False
    may_be_missing: bool = False
    defining: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """The fields that all effects share.

    `what` says in a sentence what happens, `source` where form and sizes come from. `shows_in` says what to fly so
    that the effect shows best. `variant_of` names the plain effect of the same cause: a second-order line is a
    variant of a lag. `one_model_with` names an effect of the same terms in every channel: no log tells them apart.
    An effect `for_whole_flight` is not looked for in a part of the flight: a workshop sets it, or it is a drift,
    which would jump at the ends of the part. `part_of` names the effect that this one is for a part of the flight;
    only the forms in time have it. An effect on the sensors changes the channels `changes`, and of the channels
    `also` those that the log has; it changes no others.
    """

    name: str
    family: Family
    acts_on: ClassVar[ActsOn]
    parameters: tuple[Parameter, ...]
    source: str
    what: str
    shows_in: Excitation
    variant_of: str = ""
    one_model_with: str = ""
    for_whole_flight: bool = False
    part_of: str = ""
    changes: tuple[str, ...] = ()
    also: tuple[str, ...] = ()

    @property
    def cause(self) -> str:
        """The name of the cause: that of the plain effect, which several variants may share."""
        return self.variant_of or self.name

    def parameter(self, name: str) -> Parameter:
        """Return a parameter by its name. Raises StopIteration where the effect has none of this name."""
        return next(p for p in self.parameters if p.name == name)

    def complete(self, sizes: Sizes) -> dict[str, float]:
        """Return the sizes with every parameter in them: a missing shape is `typical`, a missing size 0."""
        default = {p.name: p.typical if p.shape else 0.0 for p in self.parameters}
        return {**default, **sizes}

    def is_off(self, sizes: Sizes) -> bool:
        """Return whether all sizes are zero, so that the effect does nothing. Shapes do not count."""
        full = self.complete(sizes)
        return all(full[p.name] == 0.0 for p in self.parameters if not p.shape)

    def typical(self) -> dict[str, float]:
        """Return every parameter at its typical value."""
        return {p.name: p.typical for p in self.parameters}


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorEffect(Effect):
    """An effect on the sensors: a function that changes the time series of a log.

    `needs` are the channels that it reads. It acts on the values at the probes, before noise and sampling; with
    `after_noise` it acts on the samples as the recorder stores them.
    """

    acts_on: ClassVar[ActsOn] = "sensors"
    function: SensorFunction
    needs: tuple[str, ...] = ()
    after_noise: bool = False

    def apply(self, signals: Signals, sizes: Sizes) -> Signals:
        """Return the signals with the effect in them; at size zero, the same object.

        Raises BadInputError that names a channel which the effect needs and the signals lack.
        """
        if self.is_off(sizes):
            return signals
        signals.require(self.name, (*self.needs, *self.changes))
        return self.function(signals, self.complete(sizes))


@dataclass(frozen=True, slots=True, kw_only=True)
class AircraftEffect(Effect):
    """An effect in the airframe or the powerplant: an overlay that JSBSim loads with the unchanged aircraft."""

    acts_on: ClassVar[ActsOn] = "aircraft"
    build: Callable[[Sizes, Baseline], Overlay]

    def paths(self) -> tuple[str, ...]:
        """Return the paths of the properties that hold its numbers, in the order of the parameters."""
        return tuple(size(self.name, p.name) for p in self.parameters)

    def held(self, sizes: Sizes) -> tuple[tuple[str, float], ...]:
        """Return the properties that hold the sizes, path and value, for an overlay."""
        return tuple((size(self.name, key), value) for key, value in sizes.items())

    def overlay(self, sizes: Sizes, baseline: Baseline) -> Overlay:
        """Return the overlay for an aircraft; at size zero, an empty one.

        Raises BadInputError where the aircraft lacks the part that the effect changes.
        """
        return Overlay() if self.is_off(sizes) else self.build(self.complete(sizes), baseline)

    def fits(self, sizes: Sizes, baseline: Baseline) -> bool:
        """Return whether an aircraft has the parts that the effect changes at these sizes."""
        try:
            self.overlay(sizes, baseline)
        except BadInputError:
            return False
        return True

    def fitting(self, baseline: Baseline) -> tuple[Overlay, ...]:
        """Return the overlay for each parameter alone at its typical size, where the aircraft has the parts."""
        alone = (self.complete({p.name: p.typical}) for p in self.parameters if not p.shape)
        return tuple(self.overlay(sizes, baseline) for sizes in alone if self.fits(sizes, baseline))


@dataclass(frozen=True, slots=True, kw_only=True)
class AirEffect(AircraftEffect):
    """An effect in the air: wind in time and space, turbulence, temperature.

    `wind(signals, sizes)` returns the wind of the effect toward north, east and down [m/s], (n,) each, over the
    time and altitude of a log. It is None for effects without such a wind, for example stronger turbulence.
    """

    acts_on: ClassVar[ActsOn] = "air"
    wind: Callable[[Signals, Sizes], tuple[Array, Array, Array]] | None = None
