"""The effects that a case names, with sizes, for the whole flight or for a part of it."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import reduce
from math import inf, isfinite
from typing import Protocol

import numpy as np

from pitotbench.catalog import Catalog, explain
from pitotbench.effects.effect import AircraftEffect, AirEffect, Effect, Parameter, SensorEffect, Sizes
from pitotbench.effects.overlay import (
    Baseline,
    Expression,
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
from pitotbench.units import Array, Seconds

# Time since the first recorded sample, in a log and as an expression of JSBSim.

RECORDING_START = "bench/recording-start-s"  # simulator's time of the first recorded sample; far ahead until then
ELAPSED = operation("max", 0.0, difference("simulation/sim-time-sec", RECORDING_START))


def elapsed(signals: Signals) -> Seconds:
    """Return the time since the first sample [s], (n,)."""
    return np.asarray(signals.time - signals.time[0])


def clipped(term: Term) -> str:
    """Return an expression that limits a term to 0 … 1."""
    return operation("max", 0.0, operation("min", 1.0, term))


# Let any effect act for a part of the flight: from a time on, or between two times.
# Every effect has two further forms. Their sizes are those of the effect, times a share that rises from 0 to 1
# within `EDGE` from `from_s` on, and falls to 0 within `EDGE` before `to_s`. Times count from the first recorded
# sample.

EDGE = 2.0  # s; a lever takes about as long, and a step at once would be a spike of acceleration in a log
FROM = Parameter("from_s", 60.0, 0.0, 1e5, "time since the first sample at which it begins", shape=True)
TO = Parameter("to_s", 120.0, 0.0, 1e5, "time since the first sample at which it has ended", shape=True)
ANGLES = ("roll", "heading")  # channels that start again at a full turn
FULL_TURN = 2.0 * np.pi
NOWHERE = Baseline("none", (0.0, 0.0, 0.0))  # effects in the air need no data of an aircraft


def forms_in_time(effect: Effect) -> tuple[Effect, ...]:
    """Return an effect from a time on and for a time. Effects that have times of their own have no such forms.

    Nor has warmer air: the simulator's standard day lasts for the whole flight.
    """
    has_times = any(p.shape and p.name in ("at_s", FROM.name) for p in effect.parameters)
    if has_times or _warms(effect):
        return ()
    return (_form(effect, "from_a_time", (FROM,)), _form(effect, "for_a_time", (FROM, TO)))


def share_of_size(effect: Effect, time: Seconds, sizes: Sizes) -> Array:
    """Return the share of its sizes with which an effect acts, 0 to 1, (n,); `time` since the first sample [s]."""
    if not effect.part_of:
        return np.ones(len(time))
    full = effect.complete(sizes)
    left = full[TO.name] - time if TO.name in full else np.full(len(time), np.inf)
    return np.clip(np.minimum(time - full[FROM.name], left) / EDGE, 0.0, 1.0)


def _warms(effect: Effect) -> bool:
    """Whether an effect warms the air."""
    return isinstance(effect, AirEffect) and effect.overlay(effect.typical(), NOWHERE).temperature_offset != 0.0


def _form(effect: Effect, when: str, times: tuple[Parameter, ...]) -> Effect:
    form: Effect = replace(
        effect,
        name=f"{effect.name}_{when}",
        parameters=(*effect.parameters, *times),
        variant_of=effect.cause,
        one_model_with="",  # told of the plain effect alone
        part_of=effect.name,
        what=f"{effect.what.rstrip('.')}, {when.replace('_', ' ')}{' on' if len(times) == 1 else ''}.",
    )
    if isinstance(form, SensorEffect):
        return _on_sensors(form)
    if isinstance(form, AirEffect) and form.wind is not None:
        form = _in_air(form)
    return _on_aircraft(form, effect) if isinstance(form, AircraftEffect) else form


def _on_sensors(form: SensorEffect) -> SensorEffect:
    whole = form.function

    def function(signals: Signals, sizes: Mapping[str, float]) -> Signals:
        changed, share = whole(signals, sizes), share_of_size(form, elapsed(signals), sizes)
        names = (name for name in changed if changed[name] is not signals[name])
        if form.after_noise:  # a recorder repeats and rounds values or does not; nothing lies between
            on = share >= 0.5
            return signals.with_channels(**{n: np.where(on, changed[n], signals[n]) for n in names})
        return signals.with_channels(**{n: _between(n, signals[n], changed[n], share) for n in names})

    return replace(form, function=function)


def _between(name: str, before: Array, after: Array, share: Array) -> Array:
    """Values that change from `before` to `after` with a share; exactly one of them where the share is 0 or 1."""
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


def _on_aircraft(form: AircraftEffect, effect: Effect) -> AircraftEffect:
    whole = form.build

    def build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
        overlay = whole({p.name: sizes[p.name] for p in effect.parameters}, baseline)
        times = [p.name for p in (FROM, TO) if p.name in sizes]
        plain = overlay.renamed(lambda text: _scaled(text, form, effect, times))
        known = dict(plain.sizes)
        added = tuple((size(form.name, name), sizes[name]) for name in times)
        return replace(plain, sizes=(*known.items(), *added))

    return replace(form, build=build)


def _scaled(text: str, form: Effect, effect: Effect, times: list[str]) -> str:
    """Return an expression or a path with the properties of the effect renamed, and its sizes scaled."""
    own, new = (size(name, "") for name in (effect.name, form.name))
    scaled = text.replace(own, new)
    for parameter in effect.parameters:
        if not parameter.shape:
            node = f"<property>{size(form.name, parameter.name)}</property>"
            scaled = scaled.replace(node, product(node, _share(form, times)))
    return scaled


def _share(form: Effect, times: list[str]) -> Expression:
    since = quotient(difference(ELAPSED, size(form.name, FROM.name)), EDGE)
    left = [quotient(difference(size(form.name, TO.name), ELAPSED), EDGE)] if TO.name in times else []
    return clipped(reduce(lambda a, b: operation("min", a, b), [since, *left]))


# Turn the effects that a case names into effects with sizes, or raise one error that lists every problem.


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

    An entry with `from_s`, or with `from_s` and `to_s`, is the form of its effect for that part of the flight.
    Raises UnknownNameError for an unknown effect. Raises BadInputError, with all problems in one message, for an
    effect that is named twice and for parameters that are unknown, missing or implausible.
    """
    chosen = [Choice(_in_time(effects[entry.name], entry.parameters), entry.parameters) for entry in entries]
    counts = Counter(c.effect.name for c in chosen)
    problems = [f"{name}: named {n} times; name it once" for name, n in counts.items() if n > 1]
    problems += [problem for c in chosen for problem in _problems(c)]
    if problems:
        raise BadInputError("effects: " + "; ".join(problems))
    return tuple(c for c in chosen if not c.effect.is_off(c.sizes))


def _in_time(effect: Effect, parameters: Mapping[str, float]) -> Effect:
    """The form of an effect that has the times which are given; the effect itself where it has none."""
    times = {name for name in (FROM.name, TO.name) if name in parameters}
    known = {p.name for p in effect.parameters}
    return next(
        (f for f in forms_in_time(effect) if times and {p.name for p in f.parameters} == known | times), effect
    )


def _problems(choice: Choice) -> Iterator[str]:
    name, known = choice.effect.name, {p.name: p for p in choice.effect.parameters}
    for key, value in choice.sizes.items():
        if key not in known:
            yield f"{name}: {explain('parameter', key, list(known)).rstrip('.')}"
        elif not _plausible(value, known[key]):
            p = known[key]
            yield f"{name}: {key} = {value:g} is not within {p.low:g} to {p.high:g}"
    if choice.effect.part_of and choice.sizes.get(TO.name, inf) <= choice.sizes[FROM.name]:
        yield f"{name}: {TO.name} is not later than {FROM.name}"
    sizes = [p for p in known.values() if not (p.shape or p.may_be_missing)]
    for p in sizes:
        if p.name not in choice.sizes:
            yield f"{name}: {p.name} is missing (typically {p.typical:g}; 0 for none)"


def _plausible(value: float, parameter: Parameter) -> bool:
    # Zero switches an effect off, so it is always allowed; a time or a damping of zero is no shape.
    off = value == 0.0 and not parameter.shape
    return isfinite(value) and (off or parameter.low <= value <= parameter.high)
