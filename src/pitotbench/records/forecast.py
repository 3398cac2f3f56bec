"""A plan: the forecast bounds of cards that have not been flown yet."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil, floor
from typing import Any

import numpy as np

from pitotbench.records import Shown
from pitotbench.units import Array, MetersPerSecond

# without minutes in the request, maneuvers are compared for this flight time
COMPARED_MINUTES = 6.0
_SLACK = 1e-9  # of a count of whole flights: what rounding may take from it


@dataclass(frozen=True, slots=True)
class BriefedLeg:
    """A leg as it stands on the card of its pilot.

    What it is, how long it takes [s], its bank [rad], positive to the right, and at its end the
    heading [rad] and the airspeed [m/s]. `turned` is the angle through which it turns [rad], with
    its whole circles.
    """

    what: str
    seconds: float
    bank: float
    heading: float
    airspeed: float
    turned: float = 0.0


@dataclass(frozen=True, slots=True)
class Forecast:
    """The forecast of a card.

    `two_sigma` [m/s] at `airspeeds` [m/s, indicated] is the calibrator's bound, the mean over draws
    of gusts and sensor noise whose level it has to estimate. `known_noise_two_sigma` [m/s] is the
    bound for known noise, from the inverse information matrix. `spread` [m/s] is the standard
    deviation, from flight to flight, of the bound averaged over the airspeeds. `extent` [m]: the
    ground covered north-south and east-west, in the wind. `steepest_bank` [rad]. `card`: the
    changed numbers of the card; the unit is in each key. `legs`: the same for the pilot. `track`:
    north and east [m], (2, k), NaN at gaps. `minutes` are recorded; `elapsed_minutes`
    add the set-ups between the speeds.
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
    legs: tuple[BriefedLeg, ...] = ()

    @property
    def mean(self) -> float:
        """The predicted 2σ [m/s], averaged over the airspeeds."""
        return float(np.mean(self.two_sigma))

    @property
    def noise_cost(self) -> float:
        """Predicted 2σ over that for known noise: the cost of having to estimate the noise."""
        return self.mean / float(np.mean(self.known_noise_two_sigma))

    def times_in(self, minutes: float | None) -> int:
        """How often the card fits into the minutes; once where it does not, or none are given."""
        return max(1, floor((minutes or 0.0) / self.minutes + _SLACK))

    def within(self, minutes: float | None) -> float:
        """2σ [m/s] of the card flown as often as it fits into the minutes."""
        return self.mean / float(np.sqrt(self.times_in(minutes)))

    def mean_in(self, minutes: float) -> float:
        """2σ [m/s] after so many minutes of this card flown repeatedly: the information adds up."""
        return self.mean * float(np.sqrt(self.minutes / minutes))

    def times_for(self, want: float) -> int:
        """How often the card is to be flown for a 2σ [m/s] of at most `want`."""
        return max(1, ceil((self.mean / want) ** 2 - _SLACK))

    def ends_in(self, minutes: float | None) -> bool:
        """Whether the card is flown once within the minutes, if any are given."""
        return minutes is None or self.minutes <= minutes

    def fits(self, box: float | None) -> bool:
        """Whether the recorded ground track fits into a square box of a side [m]."""
        return box is None or max(self.extent) <= box


@dataclass(frozen=True, slots=True, repr=False)
class Plan(Shown):
    """The answer to "what should I fly?".

    `forecasts` are in order of merit; `refused` gives, by maneuver, the reason why it cannot be
    flown. `best` is the best maneuver that fits into the minutes and the box, `gentle` the best of
    those without steep turns; each is None where there is none. `improved` is the card of the best
    one with its free numbers changed; None where there was no search or the search found nothing
    better. `minutes`, `want` [m/s, 2σ] and `box` [m, side] are the request, None where they do not
    matter. `conditions` are in words.
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
