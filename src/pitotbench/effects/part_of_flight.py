"""Let any effect act for a part of the flight: from a time on, or between two times.

Every effect has two further forms. Their sizes are those of the effect, times a share that rises from 0 to 1 within
`EDGE` from `from_s` on, and falls to 0 within `EDGE` before `to_s`. Times count from the first recorded sample.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import reduce
from typing import TypeVar

import numpy as np

from pitotbench.effects.air.recorded_time import ELAPSED, clipped, elapsed
from pitotbench.effects.effect import AircraftEffect, AirEffect, Effect, Parameter, SensorEffect, Sizes
from pitotbench.effects.expression import Expression, difference, operation, product, quotient, size
from pitotbench.effects.overlay import Baseline, Overlay
from pitotbench.effects.signals import Signals
from pitotbench.units import Array, Seconds

EDGE = 2.0  # s; a lever takes about as long, and a step at once would be a spike of acceleration in a log
FROM = Parameter("from_s", 60.0, 0.0, 1e5, "time since the first sample at which it begins", shape=True)
TO = Parameter("to_s", 120.0, 0.0, 1e5, "time since the first sample at which it has ended", shape=True)
ANGLES = ("roll", "heading")  # channels that start again at a full turn
FULL_TURN = 2.0 * np.pi
NOWHERE = Baseline("none", (0.0, 0.0, 0.0))  # effects in the air need no data of an aircraft

AnyEffect = TypeVar("AnyEffect", bound=Effect)


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
