"""The next flight of a reconciliation: the cards that were considered, and the case to fly."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class CardForecast:
    """What a card that has not been flown promises.

    `card` holds its changed numbers, each key with its unit; `altitude` [m]. `name` is the probability that a
    flight of it, joined with the flights so far, gives the right name; `entropy` [bit] is what is expected to
    be left of the doubt. `minutes` are recorded.
    """

    maneuver: str
    card: Mapping[str, Any]
    altitude: float
    minutes: float
    name: float
    entropy: float


@dataclass(frozen=True, slots=True)
class AdvisedFlight:
    """The next flight.

    `causes` are the sets of causes to be parted, with their probabilities so far, `ranked` the cards, the best
    first. `parts` says whether the best one can part them. `case` is the text of the case file to fly, empty where
    no card can. `entropy` [bit] is the doubt so far.
    """

    causes: tuple[tuple[tuple[str, ...], float], ...]
    ranked: tuple[CardForecast, ...]
    parts: bool
    case: str
    entropy: float

    @property
    def best(self) -> CardForecast:
        """The card to fly."""
        return self.ranked[0]
