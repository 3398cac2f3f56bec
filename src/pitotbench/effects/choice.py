"""Turn the effects that a case names into effects with sizes, or raise one error that lists every problem."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import inf, isfinite
from typing import Protocol

from pitotbench.catalog import Catalog, explain
from pitotbench.effects.effect import Effect, Parameter
from pitotbench.effects.part_of_flight import FROM, TO, forms_in_time
from pitotbench.records.errors import BadInputError


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
