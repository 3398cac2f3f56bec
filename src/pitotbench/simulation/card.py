"""The numbers that every flight-test card holds, and how a case overrides them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from typing import Any, TypeVar

from pitotbench.catalog import UnknownNameError, explain
from pitotbench.records import BadInputError
from pitotbench.units import DEGREE, SUFFIXES, to_si

CardType = TypeVar("CardType", bound="Card")
ABOVE_ZERO = ("kt", "degps", "ft", "inhg")  # units of numbers that are nothing else


def _si(value: float, suffix: str) -> float:
    return float(to_si(value, suffix))


def quantity(value: float | Sequence[float], suffix: str, **rules: Any) -> Any:
    """Declare a field of a card: the default is written in the unit of a suffix and stored in SI.

    Speeds, rates, heights and pressures are above zero, times not below it. Further `rules` may be
    `positive`, `decreasing`, `as_many_as` another field and, for a bank, `steep`.
    """
    default = (
        tuple(_si(v, suffix) for v in value) if isinstance(value, Sequence) else _si(value, suffix)
    )
    return field(default=default, metadata={"suffix": suffix, **rules})


def count(value: float | tuple[float, ...], **rules: Any) -> Any:
    """Declare a field of a card that has no unit, with the further rules of `quantity`."""
    return field(default=value, metadata=rules)


@dataclass(frozen=True, slots=True, kw_only=True)
class Card:
    """The numbers that all maneuvers share: speeds [m/s, calibrated], turns, times, tolerances.

    A turn is flown at `turn_rate` [rad/s] or at `bank_limit` [rad], whichever needs less bank.
    After a turn the aircraft settles for `settle` [s]; where it is not yet within the tolerances,
    for up to as long again. The airspeed tolerance applies to the set-up of every maneuver, and to
    the samples of maneuvers that hold a speed.

    Raises BadInputError for a number that breaks a rule of its field.
    """

    speeds: tuple[float, ...] = quantity((160.0, 140.0, 120.0, 100.0), "kt")
    turn_rate: float = quantity(3.0, "degps")
    bank_limit: float = quantity(30.0, "deg", positive=True)
    roll_rate_limit: float = quantity(8.0, "degps")
    airspeed_rate_limit: float = quantity(2.0, "kt")  # a second
    settle: float = quantity(30.0, "s")
    airspeed_tolerance: float = quantity(1.0, "kt")
    heading_tolerance: float = quantity(2.0, "deg", positive=True)
    altitude_tolerance: float = quantity(50.0, "ft")

    def __post_init__(self) -> None:
        for entry in fields(self):
            name, rules, values = entry.name, entry.metadata, _each(getattr(self, entry.name))
            if (rules.get("positive") or rules.get("suffix") in ABOVE_ZERO) and min(values) <= 0.0:
                raise BadInputError(f"{name} of a card must be above zero")
            if rules.get("suffix") == "s" and min(values) < 0.0:
                raise BadInputError(f"{name} of a card is a time and cannot be negative")
            if rules.get("decreasing") and (
                len(values) < 2 or any(b >= a for a, b in pairwise(values))
            ):
                raise BadInputError(
                    f"{name} of a card needs at least two numbers, each below the one before"
                )
            other = rules.get("as_many_as", name)
            if len(values) != len(_each(getattr(self, other))):
                raise BadInputError(
                    f"{name} of a card must hold as many numbers as {other}: change both"
                )
            if rules.get("steep") and not 5.0 * DEGREE <= abs(values[0]) <= 60.0 * DEGREE:
                raise BadInputError(f"{name} of a card lies between 5° and 60°, to either side")


def _each(value: float | tuple[float, ...]) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,)


def override(card: CardType, changes: Mapping[str, Any]) -> CardType:
    """Return the card with changed numbers.

    Parameters: changes, a mapping from names to numbers or lists of numbers, for example
    `{"dwell_s": 20, "speeds_kt": [160, 100]}`. A name ends in any unit suffix of the right
    dimension; a count has no suffix. Raises UnknownNameError for an unknown name, BadInputError for
    a value of the wrong shape.
    """
    return replace(card, **dict(_resolve(card, key, value) for key, value in changes.items()))


def _resolve(card: Card, key: str, value: Any) -> tuple[str, Any]:
    known = {_written(f.name, f.metadata.get("suffix")): f for f in fields(card)}
    for name, entry in known.items():
        stated = entry.metadata.get("suffix")
        suffix = key.removeprefix(entry.name + "_") if stated else None
        fits = suffix in SUFFIXES and stated in SUFFIXES and _same_dimension(suffix, stated)
        if key == name or fits:
            return entry.name, _checked(key, value, getattr(card, entry.name), suffix)
    raise UnknownNameError(explain("card entry", key, list(known)))


def _checked(key: str, value: Any, present: Any, suffix: str | None) -> Any:
    """Return the SI value of an override.

    Raises BadInputError unless it has the shape of the present value.
    """
    if isinstance(present, tuple):
        if isinstance(value, str) or not isinstance(value, Sequence) or not value:
            raise BadInputError(f"{key} takes a list of numbers, not {value!r}")
        return tuple(_checked(key, one, 0.0, suffix) for one in value)
    # In Python a boolean is an integer, and TOML's `true` is no number of a card.
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise BadInputError(f"{key} takes a finite number, not {value!r}")
    if suffix:
        return _si(value, suffix)
    if isinstance(present, int) and value != int(value):
        raise BadInputError(f"{key} takes a whole number, not {value!r}")
    return type(present)(value)


def _written(name: str, suffix: str | None) -> str:
    return f"{name}_{suffix}" if suffix else name


def _same_dimension(one: str, other: str) -> bool:
    return SUFFIXES[one].dimension == SUFFIXES[other].dimension
