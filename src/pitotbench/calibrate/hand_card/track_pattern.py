"""The tracks that a card was meant to be flown on: the first leg of every point on about one track, and so on.

In little wind a wrong track leaves the airspeeds as they are; beside the same legs of the other points it shows.
"""

from collections.abc import Sequence

import numpy as np

from pitotbench.records.hand_card import CardLeg
from pitotbench.units import DEGREE

_FEWEST = 3  # other points that fly the same leg
_TIGHT = 12.0 * DEGREE  # from their middle, within which all but one of them lie


def expected_tracks(legs: Sequence[CardLeg]) -> dict[int, float]:
    """Return the track [rad] that the other points fly on each leg, by row; no entry where they show none."""
    places: dict[str, int] = {}
    by_place: dict[int, list[CardLeg]] = {}
    for leg in legs:
        places[leg.point] = places.get(leg.point, -1) + 1
        by_place.setdefault(places[leg.point], []).append(leg)
    return {
        leg.row: middle
        for group in by_place.values()
        for leg in group
        if (middle := _middle([other.track for other in group if other is not leg])) is not None
    }


def _middle(tracks: Sequence[float]) -> float | None:
    """Return the track around which all but at most one of the tracks lie; None where they do not agree."""
    if len(tracks) < _FEWEST:
        return None
    away = np.abs(turn_between(np.asarray(tracks)[:, None], np.asarray(tracks)[None, :]))
    best = int(np.argmin(np.median(away, axis=1)))
    near = away[best] <= _TIGHT
    if np.count_nonzero(~near) > 1 or np.count_nonzero(near) < _FEWEST:
        return None
    return float(tracks[best] + np.mean(turn_between(np.asarray(tracks)[near], tracks[best])))


def turn_between(one: "np.ndarray | float", other: "np.ndarray | float") -> np.ndarray:
    """Return the angle from one track to another [rad], within half a turn."""
    return np.asarray((np.asarray(one) - np.asarray(other) + np.pi) % (2.0 * np.pi) - np.pi)
