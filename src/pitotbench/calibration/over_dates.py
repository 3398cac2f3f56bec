"""Find the correction of an airplane over the dates of its flights, and a change of it."""

from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np
from scipy.special import stdtr

from pitotbench.calibration.flights import of_one_log
from pitotbench.logbook.same_flight import moment_of
from pitotbench.records.calibration import CalibratedFlight
from pitotbench.records.over_dates import DatedChange, OverDates
from pitotbench.units import KNOT, Array, MetersPerSecond

_FEWEST = 3  # dated flights, below which there is no course of the correction
_SPEEDS = (0.15, 0.5, 0.85)  # of the range of airspeeds that all flights share
_STATED = 4  # flights that the stated 2σ counts as, where the flights' own scatter is another
_CHANCE = 0.01  # of a change where there is none, below which it is named


def over_dates(
    names: Sequence[str], logs: Sequence[Sequence[CalibratedFlight]]
) -> OverDates | None:
    """Return the corrections over dates, or None for too few dates or no airspeed in common.

    The flights of each log are one correction. Too few are less than three logs with a date and an
    answer that may be used.
    """
    found = []
    for name, flights in zip(names, logs, strict=True):
        moment = moment_of(flights[0].log)
        answer = of_one_log(flights[0].log, flights)
        if moment is not None and answer.usable:
            found.append((moment, name, answer.curve))
    found.sort(key=lambda each: each[:2])
    speeds = [curve.indicated_airspeed for _, _, curve in found]
    if len(found) < _FEWEST:
        return None
    low, high = max(each[0] for each in speeds), min(each[-1] for each in speeds)
    if low >= high:
        return None
    airspeed = np.round(np.interp(_SPEEDS, (0.0, 1.0), (low, high)) / KNOT) * KNOT

    def at_airspeeds(name: str) -> Array:
        rows = [
            np.interp(airspeed, curve.indicated_airspeed, getattr(curve, name))
            for _, _, curve in found
        ]
        return np.array(rows)

    correction, two_sigma = at_airspeeds("correction"), at_airspeeds("two_sigma")
    return OverDates(
        tuple(name for _, name, _ in found),
        tuple(datetime.fromtimestamp(moment, UTC) for moment, _, _ in found),
        airspeed,
        correction,
        two_sigma,
        change_of(airspeed, correction, two_sigma),
    )


def change_of(
    airspeed: MetersPerSecond, correction: MetersPerSecond, two_sigma: MetersPerSecond
) -> DatedChange | None:
    """Return the clearest change of flights' corrections (n, c) over time, None for chance.

    The weighted means before and after each flight are compared at each airspeed. Flights that
    scatter by more than their 2σ widen the comparison (Birge, Physical Review 40, 1932); what they
    state counts as some flights of that scatter. The chance is that of the clearest of all
    comparisons (Bonferroni): errors that all flights share cancel, so that it is rather too large.
    """
    weight = 4.0 / two_sigma**2
    places = range(1, len(correction))
    freedom = len(correction) - 2 + _STATED
    sizes, errors = [], []
    for first in places:
        before, after = slice(None, first), slice(first, None)
        means = [
            np.average(correction[part], axis=0, weights=weight[part]) for part in (before, after)
        ]
        left = correction - np.repeat(means, [first, len(correction) - first], axis=0)
        spread = (np.sum(weight * left**2, axis=0) + _STATED) / freedom
        variance = sum(1.0 / weight[part].sum(axis=0) for part in (before, after))
        sizes.append(means[1] - means[0])
        errors.append(np.sqrt(variance * np.maximum(spread, 1.0)))
    departure = np.abs(sizes) / errors
    step, place = np.unravel_index(int(np.argmax(departure)), departure.shape)
    chance = min(2.0 * float(stdtr(freedom, -departure[step, place])) * departure.size, 1.0)
    if chance > _CHANCE:
        return None
    return DatedChange(
        places[step],
        float(airspeed[place]),
        float(sizes[step][place]),
        2.0 * float(errors[step][place]),
        chance,
    )
