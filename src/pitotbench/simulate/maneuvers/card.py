"""What every flight-test card holds, and how a case overrides its numbers."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from typing import Any, TypeVar

from pitotbench.catalog import UnknownNameError, explain
from pitotbench.records.errors import BadInputError
from pitotbench.units import SUFFIXES, to_si

CardType = TypeVar("CardType", bound="Card")


def _si(value: float, suffix: str) -> float:
    return float(to_si(value, suffix))


def quantity(value: float | Sequence[float], suffix: str) -> Any:
    """A card's field: a default written in the unit of a suffix, held in SI."""
    default = tuple(_si(v, suffix) for v in value) if isinstance(value, Sequence) else _si(value, suffix)
    return field(default=default, metadata={"suffix": suffix})


@dataclass(frozen=True, slots=True, kw_only=True)
class Card:
    """What all maneuvers share: speeds [m/s, calibrated], how to turn, how to settle, tolerances.

    A turn is flown at `turn_rate` or at `bank_limit`, whichever banks less. After a turn the aircraft settles
    for `settle`, and as long again at most where it is not yet within the tolerances. The airspeed tolerance
    judges the set-up of every maneuver and the samples of those that hold a speed.
    """

    speeds: tuple[float, ...] = quantity((160.0, 140.0, 120.0, 100.0), "kt")
    turn_rate: float = quantity(3.0, "degps")
    bank_limit: float = quantity(30.0, "deg")
    roll_rate_limit: float = quantity(8.0, "degps")
    airspeed_rate_limit: float = quantity(2.0, "kt")  # a second
    settle: float = quantity(30.0, "s")
    airspeed_tolerance: float = quantity(1.0, "kt")
    heading_tolerance: float = quantity(2.0, "deg")
    altitude_tolerance: float = quantity(50.0, "ft")

    def __post_init__(self) -> None:
        self.require_positive("speeds", "turn_rate", "bank_limit", "roll_rate_limit", "airspeed_rate_limit")
        self.require_positive("airspeed_tolerance", "heading_tolerance", "altitude_tolerance")
        for entry in fields(self):
            if entry.metadata.get("suffix") == "s" and min(_each(getattr(self, entry.name))) < 0.0:
                raise BadInputError(f"{entry.name} of a card is a time and cannot be negative")

    def require_positive(self, *names: str) -> None:
        """Raise BadInputError where a number of the card, or one of a list, is not above zero."""
        for name in names:
            if min(_each(getattr(self, name))) <= 0.0:
                raise BadInputError(f"{name} of a card must be above zero")

    def require_decreasing_speeds(self) -> None:
        """Raise BadInputError where the speeds are not at least two, each below the one before."""
        if len(self.speeds) < 2 or any(b >= a for a, b in pairwise(self.speeds)):
            raise BadInputError("a deceleration needs at least two speeds, each below the one before")

    def require_one_each(self, name: str, other: str) -> None:
        """Raise BadInputError where one list of the card is not as long as another."""
        if len(getattr(self, name)) != len(getattr(self, other)):
            raise BadInputError(f"{name} of a card must hold as many numbers as {other}: change both")


def _each(value: float | tuple[float, ...]) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,)


def override(card: CardType, changes: Mapping[str, Any]) -> CardType:
    """The card with changed numbers.

    Parameters: changes, name with a unit suffix of the right dimension to a number or a list of numbers, for
    example `{"dwell_s": 20, "speeds_kt": [160, 100]}`; a count has no suffix.
    Raises UnknownNameError for an unknown name, BadInputError for a value of the wrong shape.
    """
    return replace(card, **dict(_resolve(card, key, value) for key, value in changes.items()))


def _resolve(card: Card, key: str, value: Any) -> tuple[str, Any]:
    known = {_written(f.name, f.metadata.get("suffix")): f for f in fields(card)}
    for name, entry in known.items():
        own = entry.metadata.get("suffix")
        suffix = key.removeprefix(entry.name + "_") if own else None
        fits = suffix in SUFFIXES and own in SUFFIXES and _same_dimension(suffix, own)
        if key == name or fits:
            return entry.name, _checked(key, value, getattr(card, entry.name), suffix)
    raise UnknownNameError(explain("card entry", key, list(known)))


def _checked(key: str, value: Any, present: Any, suffix: str | None) -> Any:
    """The SI value of an override, of the same shape as the present one."""
    if isinstance(present, tuple):
        if isinstance(value, str) or not isinstance(value, Sequence) or not value:
            raise BadInputError(f"{key} takes a list of numbers, not {value!r}")
        return tuple(_checked(key, one, 0.0, suffix) for one in value)
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
