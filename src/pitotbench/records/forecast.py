"""A plan: what cards will give before they are flown."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil, floor
from typing import Any

import numpy as np

from pitotbench.units import Array, MetersPerSecond


@dataclass(frozen=True, slots=True)
class Forecast:
    """What is to be expected of a card.

    `two_sigma` [m/s] at `airspeeds` [m/s, indicated] is the calibrator's bound, mean over draws of gusts and sensor
    noise whose level it has to find; `known_noise_two_sigma` is the inverse information matrix alone; `spread`
    [m/s] is the standard deviation, from flight to flight, of the bound averaged over the airspeeds. `extent` [m]:
    ground covered north-south and east-west, wind included; `steepest_bank` [rad]. `card`: the
    numbers changed, keys with units. `track`: north and east [m], (2, k), NaN at
    gaps. `minutes` are recorded, `elapsed_minutes` with the set-ups between its speeds.
    """

    maneuver: str
    card: Mapping[str, Any]
    minutes: float
    elapsed_minutes: float
    steepest_bank: float
    extent: tuple[float, float]
    airspeeds: MetersPerSecond
    two_sigma: MetersPerSecond
    known_noise_two_sigma: MetersPerSecond
    spread: float
    track: Array

    @property
    def mean(self) -> float:
        """The predicted 2σ [m/s], averaged over the airspeeds."""
        return float(np.mean(self.two_sigma))

    @property
    def widening(self) -> float:
        """What not knowing the noise costs: predicted 2σ over that for known noise."""
        return self.mean / float(np.mean(self.known_noise_two_sigma))

    def within(self, minutes: float) -> float:
        """2σ [m/s] of the card flown whole as often as the minutes hold it, once at least."""
        return self.mean / float(np.sqrt(max(1, floor(minutes / self.minutes + 1e-9))))

    def mean_in(self, minutes: float) -> float:
        """2σ [m/s] after so many minutes of this card flown again and again: information adds up."""
        return self.mean * float(np.sqrt(self.minutes / minutes))

    def times_for(self, want: float) -> int:
        """How often the card is to be flown for a 2σ [m/s] of at most `want`."""
        return max(1, ceil((self.mean / want) ** 2 - 1e-9))

    def fits(self, box: float | None) -> bool:
        """Whether the recorded ground track fits into a square box of a side [m]."""
        return box is None or max(self.extent) <= box


@dataclass(frozen=True, slots=True)
class Plan:
    """The answer to "what should I fly?".

    `forecasts` in order of merit; `refused`, what cannot be flown and why; `best` of those that fit the minutes and
    the box, `gentle` the best of those with no steep turns, `improved` the best one's card with its free numbers
    changed: None where there is none, where the card was not searched or where the search found nothing better.
    `minutes`, `want` [m/s] and `box` [m] are what was asked, None where they do not matter; `conditions` in words.
    """

    conditions: str
    forecasts: tuple[Forecast, ...]
    refused: Mapping[str, str]
    best: Forecast | None
    gentle: Forecast | None
    improved: Forecast | None
    flights_searched: int
    minutes: float | None = None
    want: float | None = None
    box: float | None = None
