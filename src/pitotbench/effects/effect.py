"""The records of an effect, and the effects that a case names with their sizes.

The sizes are for a flight or for a part of it.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import ClassVar, Literal, Protocol

import numpy as np

from pitotbench.catalog import Catalog, explain
from pitotbench.effects.overlay import (
    Baseline,
    Dimension,
    Overlay,
    Term,
    difference,
    operation,
    product,
    quotient,
    size,
)
from pitotbench.effects.response import Signals
from pitotbench.records import BadInputError
from pitotbench.records.calibration import Estimate
from pitotbench.units import FOOT, FULL_TURN, POUND, Array, Seconds


@dataclass(frozen=True, slots=True)
class Excitation:
    """A way of flying that makes an effect show.

    `maneuvers` are names of the table of maneuvers, the best one first. `text` describes the flying
    in words.
    """

    maneuvers: tuple[str, ...]
    text: str

    def __str__(self) -> str:
        return f"{self.text} ({', '.join(self.maneuvers)})"


CHANGING_AIRSPEED = Excitation(
    ("rapid_decel",), "idle decelerations on opposite headings, and the acceleration between them"
)
CHANGING_HEIGHT = Excitation(("diagnostic",), "a climb and a descent at constant airspeed")
TURNING = Excitation(
    ("circle", "figure_eight"), "full circles at 30° of bank to one side, or at 45° to both"
)
SIDESLIP = Excitation(("diagnostic",), "steady-heading sideslips to both sides")
POWER = Excitation(
    ("diagnostic",), "one airspeed with high and low power, in a climb and a descent"
)
RANGE_OF_AIRSPEED = Excitation(
    ("four_leg",), "level flight from the highest to the lowest airspeed"
)
STEPS_OF_AIRSPEED = Excitation(
    ("step_decrease", "step_both_ways"), "level flight in small steps of airspeed, both ways"
)
STEADY_LEGS = Excitation(("race_track",), "long level legs at constant airspeed and power")
EARLY_AND_LATE = Excitation(("race_track",), "the same airspeeds early and late in one long log")
TEMPERATURE = Excitation(
    ("race_track",),
    "legs on reciprocal headings at the highest and lowest airspeed, with a balloon's temperature",
)


ActsOn = Literal["sensors", "air", "aircraft"]
Part = Literal[  # what a mechanic inspects, or the day; an effect of a formula has none
    "",
    "pitot line",
    "pitot head",
    "static ports and line",
    "static transducer",
    "impact transducer",
    "thermometer, or the day",
    "GPS receiver and its clock",
    "attitude and inertial unit",
    "flow vanes",
    "recorder",
    "air",
    "drag",
    "loading",
    "controls and trim",
    "lift, stability and damping",
    "engine or propeller, a side",
    "engine instruments",
]
Sizes = Mapping[str, float]
SensorFunction = Callable[[Signals, Sizes], Signals]


def reads(channel: str, read: Callable[[Array, Sizes], Array]) -> SensorFunction:
    """Return the function by which `read` turns true values of a channel, (n,), into those read."""
    return lambda signals, sizes: signals.with_channels(**{channel: read(signals[channel], sizes)})


# of the airplane for which the sizes of the table are stated; its file has the sources
NAVAJO: Mapping[Dimension, float] = {
    "empty mass": 4060.0 * POUND,
    "wing area": 229.0 * FOOT**2,
    "chord": 5.80 * FOOT,
}


def to_navajo(baseline: Baseline, dimension: Dimension) -> float:
    """Return a dimension of an airplane over the navajo's; 1 where its file does not tell it."""
    return baseline.dimensions.get(dimension, NAVAJO[dimension]) / NAVAJO[dimension]


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of an effect. Its name ends in its unit; a number without dimension has no unit.

    A size lies between `low` and `high`; zero means no effect and is always allowed. A `shape`,
    such as a time or a damping, says what form the effect has, not its size: a case may omit it,
    and then it is `typical`. A size that `may_be_missing` is 0 where a case omits it. Without a
    size that is `defining` the effect is its `neighbor` in the table: a line with water in it, but
    no water, is a line that is late. A size that `grows_with` a dimension is stated for the navajo.
    """

    name: str
    typical: float
    low: float
    high: float
    what: str
    shape: bool = False
    may_be_missing: bool = False
    defining: bool = False
    grows_with: Dimension | None = None

    def of_airplane(self, baseline: Baseline) -> "Parameter":
        """Return the parameter with typical size and range in proportion to another airplane.

        They grow with the dimension `grows_with`. The parameter is unchanged where the airplane's
        file does not give that dimension.
        """
        if self.grows_with is None:
            return self
        ratio = to_navajo(baseline, self.grows_with)
        return replace(
            self, typical=ratio * self.typical, low=ratio * self.low, high=ratio * self.high
        )

    def within(self, value: float) -> float:
        """Return a value, or the end of the plausible range that it is beyond."""
        return min(max(value, self.low), self.high)

    def is_possible(self, size: Estimate) -> bool:
        """Return whether a size lies in the plausible range, with some slack.

        The slack is the size's 2σ and half a typical size.
        """
        slack = size.two_sigma + 0.5 * abs(self.typical)
        return self.low - slack <= size.value <= self.high + slack


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """What all effects have: a name, parameters, a source, and how `reconcile` looks for them."""

    name: str
    acts_on: ClassVar[ActsOn]
    parameters: tuple[Parameter, ...]
    source: str  # where its form and its sizes come from: author and year
    what: str  # what happens, in one sentence
    shows_in: Excitation  # what to fly so that it shows best
    part: Part = ""  # of the airplane, its instruments or the world, that has it
    variant_of: str = ""  # plain effect of the same cause: of a second-order line, a lag
    neighbor: str = ""  # effect that it is without its defining size
    one_model_with: str = ""  # effect of the same terms in every channel: no log separates them
    # effects that its form may hold a little of: a pod pitches the airplane, by an unknown arm
    left_open: tuple[str, ...] = ()
    by_size: bool = False  # each size may be there alone, as one surface that is off
    # not looked for in a part of the flight: a workshop sets it, or it is a drift, which would jump
    # at the ends of the part
    for_whole_flight: bool = False
    # looked for with vanes only: without them the lift alone shows it, as it shows what the form of
    # another term leaves
    by_vanes: bool = False
    like_without_vanes: bool = False  # no log without vanes separates those that have it
    part_of: str = ""  # effect that it is for a part of the flight; only forms in time have it
    changes: tuple[str, ...] = ()  # channels that it needs and changes; it changes no others
    also: tuple[str, ...] = ()  # channels that it changes where the log has them

    @property
    def cause(self) -> str:
        """The name of the cause: that of the plain effect, which several variants may share."""
        return self.variant_of or self.name

    def parameter(self, name: str) -> Parameter:
        """Return a parameter by its name.

        Raises UnknownNameError where the effect has none of this name.
        """
        return Catalog(f"parameter of {self.name}", {p.name: p for p in self.parameters})[name]

    def complete(self, sizes: Sizes) -> dict[str, float]:
        """Return the sizes with every parameter: a missing shape is `typical`, a missing size 0."""
        default = {p.name: p.typical if p.shape else 0.0 for p in self.parameters}
        return {**default, **sizes}

    def is_off(self, sizes: Sizes) -> bool:
        """Return whether all sizes are zero, whatever the shapes: the effect does nothing."""
        full = self.complete(sizes)
        return all(full[p.name] == 0.0 for p in self.parameters if not p.shape)

    def typical(self) -> dict[str, float]:
        """Return every parameter at its typical value."""
        return {p.name: p.typical for p in self.parameters}


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorEffect(Effect):
    """An effect on the sensors: a function that changes the time series of a log.

    `needs` are the channels that it reads. It acts on the values at the probes, before noise and
    sampling; with `after_noise` it acts on the samples as the recorder stores them.
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
    """An effect in the airframe or the powerplant: an overlay on the unchanged aircraft in JSBSim.

    `build` takes the effect itself, its sizes and the aircraft.
    """

    acts_on: ClassVar[ActsOn] = "aircraft"
    build: "Build"

    def paths(self) -> tuple[str, ...]:
        """Return the paths of the properties of its numbers, in the parameters' order."""
        return tuple(size(self.name, p.name) for p in self.parameters)

    def properties(self, sizes: Sizes) -> tuple[tuple[str, float], ...]:
        """Return the properties of the sizes, path and value, for an overlay."""
        return tuple((size(self.name, key), value) for key, value in sizes.items())

    def overlay(self, sizes: Sizes, baseline: Baseline) -> Overlay:
        """Return the overlay for an aircraft; at size zero, an empty one.

        Raises BadInputError where the aircraft lacks the part that the effect changes.
        """
        return Overlay() if self.is_off(sizes) else self.build(self, self.complete(sizes), baseline)

    def fits(self, sizes: Sizes, baseline: Baseline) -> bool:
        """Return whether an aircraft has the parts that the effect changes at these sizes."""
        try:
            self.overlay(sizes, baseline)
        except BadInputError:
            return False
        return True

    def fitting(self, baseline: Baseline) -> tuple[Overlay, ...]:
        """Return one overlay for each parameter alone, at its typical size, that fits the aircraft.

        A parameter fits where the aircraft has the parts that it changes.
        """
        alone = (self.complete({p.name: p.typical}) for p in self.parameters if not p.shape)
        return tuple(self.overlay(sizes, baseline) for sizes in alone if self.fits(sizes, baseline))


Build = Callable[[AircraftEffect, Sizes, Baseline], Overlay]


@dataclass(frozen=True, slots=True, kw_only=True)
class AirEffect(AircraftEffect):
    """An effect in the air: wind in time and space, turbulence, temperature.

    `wind(signals, sizes)` returns the wind of the effect toward north, east and down [m/s], (n,)
    each, over the time and altitude of a log. It is None for effects without such a wind, for
    example stronger turbulence.
    """

    acts_on: ClassVar[ActsOn] = "air"
    wind: Callable[[Signals, Sizes], tuple[Array, Array, Array]] | None = None


# simulator's time of the first recorded sample; far ahead until then
RECORDING_START = "bench/recording-start-s"
ELAPSED = operation("max", 0.0, difference("simulation/sim-time-sec", RECORDING_START))


def elapsed(signals: Signals) -> Seconds:
    """Return the time since the first sample [s], (n,)."""
    return np.asarray(signals.time - signals.time[0])


def clipped(term: Term) -> str:
    """Return an expression that limits a term to 0 … 1."""
    return operation("max", 0.0, operation("min", 1.0, term))


EDGE = 2.0  # s; a lever takes about as long, and a step at once would be a spike of acceleration in a log
FROM = Parameter(
    "from_s", 60.0, 0.0, 1e5, "time since the first sample at which it begins", shape=True
)
TO = Parameter(
    "to_s", 120.0, 0.0, 1e5, "time since the first sample at which it has ended", shape=True
)
ANGLES = ("roll", "heading")  # channels that start again at a full turn
NOWHERE = Baseline("none", (0.0, 0.0, 0.0))  # effects in the air need no data of an aircraft


def forms_in_time(effect: Effect) -> tuple[Effect, ...]:
    """Return the forms of an effect from a time on and for a time, () where it has its own times.

    Warmer air has none either: the simulator's standard day lasts for the whole flight. The sizes
    of a form are those of the effect, times a share that rises from 0 to 1 within `EDGE` from
    `from_s` on, and falls to 0 within `EDGE` before `to_s`. Times count from the first recorded
    sample.
    """
    has_times = any(p.shape and p.name in ("at_s", FROM.name) for p in effect.parameters)
    if has_times or (
        isinstance(effect, AirEffect)
        and effect.overlay(effect.typical(), NOWHERE).temperature_offset != 0.0
    ):
        return ()
    return (_form(effect, "from_a_time", (FROM,)), _form(effect, "for_a_time", (FROM, TO)))


def share_of_size(effect: Effect, time: Seconds, sizes: Sizes) -> Array:
    """Return the share, 0 to 1, (n,), of its sizes with which an effect acts at a `time` [s].

    The time counts from the first sample.
    """
    if not effect.part_of:
        return np.ones(len(time))
    full = effect.complete(sizes)
    left = full[TO.name] - time if TO.name in full else np.full(len(time), np.inf)
    return np.clip(np.minimum(time - full[FROM.name], left) / EDGE, 0.0, 1.0)


def _form(effect: Effect, when: str, times: tuple[Parameter, ...]) -> Effect:
    form: Effect = replace(
        effect,
        name=f"{effect.name}_{when}",
        parameters=(*effect.parameters, *times),
        variant_of=effect.cause,
        one_model_with="",  # stated for the plain effect alone
        part_of=effect.name,
        what=f"{effect.what.rstrip('.')}, "
        f"{when.replace('_', ' ')}{' on' if len(times) == 1 else ''}.",
    )
    if isinstance(form, SensorEffect):
        return _on_sensors(form)
    if isinstance(form, AirEffect) and form.wind is not None:
        form = _in_air(form)
    if isinstance(form, AircraftEffect) and isinstance(effect, AircraftEffect):
        return _on_aircraft(form, effect)
    return form


def _on_sensors(form: SensorEffect) -> SensorEffect:
    whole = form.function

    def function(signals: Signals, sizes: Mapping[str, float]) -> Signals:
        changed, share = whole(signals, sizes), share_of_size(form, elapsed(signals), sizes)
        names = (name for name in changed if changed[name] is not signals[name])
        # A recorder repeats and rounds values or does not; nothing lies between.
        if form.after_noise:
            on = share >= 0.5
            return signals.with_channels(**{n: np.where(on, changed[n], signals[n]) for n in names})
        return signals.with_channels(
            **{n: _between(n, signals[n], changed[n], share) for n in names}
        )

    return replace(form, function=function)


def _between(name: str, before: Array, after: Array, share: Array) -> Array:
    """Values between `before` and `after` by a share; exactly these where the share is 0 or 1."""
    change = after - before
    if name in ANGLES:
        change = np.mod(change + np.pi, FULL_TURN) - np.pi
    part = before + share * change
    return np.where(share == 1.0, after, np.where(share == 0.0, before, part))


def _in_air(form: AirEffect) -> AirEffect:
    whole = form.wind
    assert whole is not None

    def wind(signals: Signals, sizes: Mapping[str, float]) -> tuple[Array, Array, Array]:
        share = share_of_size(form, elapsed(signals), sizes)
        north, east, down = whole(signals, sizes)
        return share * north, share * east, share * down

    return replace(form, wind=wind)


def _on_aircraft(form: AircraftEffect, effect: AircraftEffect) -> AircraftEffect:
    def build(_: AircraftEffect, sizes: Sizes, baseline: Baseline) -> Overlay:
        overlay = effect.build(effect, {p.name: sizes[p.name] for p in effect.parameters}, baseline)
        times = [p.name for p in (FROM, TO) if p.name in sizes]
        plain = overlay.renamed(lambda text: _scaled(text, form, effect, times))
        added = tuple((size(form.name, name), sizes[name]) for name in times)
        return replace(plain, sizes=(*plain.sizes, *added))

    return replace(form, build=build)


def _scaled(text: str, form: Effect, effect: Effect, times: list[str]) -> str:
    """Return an expression or a path of `effect` for its `form`: renamed, with sizes scaled."""
    own, new = (size(name, "") for name in (effect.name, form.name))
    share = quotient(difference(ELAPSED, size(form.name, FROM.name)), EDGE)
    if TO.name in times:
        share = operation(
            "min", share, quotient(difference(size(form.name, TO.name), ELAPSED), EDGE)
        )
    scaled = text.replace(own, new)
    for parameter in effect.parameters:
        if not parameter.shape:
            node = f"<property>{size(form.name, parameter.name)}</property>"
            scaled = scaled.replace(node, product(node, clipped(share)))
    return scaled


class Named(Protocol):
    """An entry of a case: the name of an effect and its parameters."""

    @property
    def name(self) -> str: ...

    @property
    def parameters(self) -> Mapping[str, float]: ...


@dataclass(frozen=True, slots=True)
class Choice:
    """An effect of the table and its sizes, in the units of its parameters."""

    effect: Effect
    sizes: Mapping[str, float]


def choose(entries: Iterable[Named], effects: Catalog[Effect]) -> tuple[Choice, ...]:
    """Check the effects of a case and return those whose size is not zero.

    An entry with `from_s`, or with `from_s` and `to_s`, is the form of its effect for that part of
    the flight. Raises UnknownNameError for an unknown effect. Raises BadInputError, with all
    problems in one message, for an effect that is named twice and for parameters that are unknown,
    missing or implausible.
    """
    chosen = [
        Choice(_in_time(effects[entry.name], entry.parameters), entry.parameters)
        for entry in entries
    ]
    counts = Counter(c.effect.name for c in chosen)
    problems = [f"{name}: named {n} times; name it once" for name, n in counts.items() if n > 1]
    problems += [problem for c in chosen for problem in _problems(c)]
    if problems:
        raise BadInputError("effects: " + "; ".join(problems))
    return tuple(c for c in chosen if not c.effect.is_off(c.sizes))


def _in_time(effect: Effect, parameters: Mapping[str, float]) -> Effect:
    """The form of an effect that has just the times given, else the effect itself."""
    times = {name for name in (FROM.name, TO.name) if name in parameters}
    known = {p.name for p in effect.parameters}
    return next(
        (
            f
            for f in forms_in_time(effect)
            if times and {p.name for p in f.parameters} == known | times
        ),
        effect,
    )


def _problems(choice: Choice) -> Iterator[str]:
    name, known = choice.effect.name, {p.name: p for p in choice.effect.parameters}
    for key, value in choice.sizes.items():
        if key not in known:
            yield f"{name}: {explain('parameter', key, list(known)).rstrip('.')}"
            continue
        p = known[key]
        # Zero switches an effect off, so it is always allowed; a time or a damping of zero is no
        # shape.
        off = value == 0.0 and not p.shape
        if not (isfinite(value) and (off or p.low <= value <= p.high)):
            yield f"{name}: {key} = {value:g} is not within {p.low:g} to {p.high:g}"
    if choice.effect.part_of and choice.sizes.get(TO.name, inf) <= choice.sizes[FROM.name]:
        yield f"{name}: {TO.name} is not later than {FROM.name}"
    for p in known.values():
        if not (p.shape or p.may_be_missing or p.name in choice.sizes):
            yield f"{name}: {p.name} is missing (typically {p.typical:g}; 0 for none)"
