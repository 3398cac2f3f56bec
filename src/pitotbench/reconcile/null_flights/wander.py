"""How far a channel wanders, against null flights: a gap that neither an effect nor a cell explains.

A gap that follows no variable, such as an error that comes and goes, does not change any mean. It shows only in
the sum of squares of its channel. Louder noise does not count, not even for a part of the flight: a wander is more
than the median of the innovations nearby tells.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from pitotbench.estimate.robust_scale import robust_deviation
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution
from pitotbench.reconcile.null_flights.null_measure import Measure, measures_over
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.layout_noise import noise_residuals
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.records.verdict import Located

GUSTY = ("airspeed_along", "airspeed_across", "airspeed_down")  # in turbulence, gust_levels.py judges these
SMALLEST = 1e-12  # of a mean square whose logarithm is taken


def channel_powers(layout: Layout, noise: NoiseModel) -> dict[str, float]:
    """Return the logarithm of the mean square innovation of each channel, each over its usual size nearby.

    The usual size is the robust deviation of the instants nearby. Louder sensors, or an airplane that answers gusts
    more, raise both.
    """
    innovations = noise.innovations(noise_residuals(layout), layout.grid, layout.residuals.slack)
    used = innovations[np.any(innovations != 0.0, axis=1)]
    least = THRESHOLDS.wander_nearby_lowest * robust_deviation(used)
    stretches = np.array_split(used, max(1, len(used) // THRESHOLDS.wander_nearby))
    sizes = [np.maximum(robust_deviation(part), least) for part in stretches]
    squares = np.concatenate([p**2 / (s**2 + SMALLEST) for p, s in zip(stretches, sizes, strict=True)])
    powers = np.log(np.mean(squares, axis=0) + SMALLEST)
    return dict(zip(layout.residuals.names, powers.tolist(), strict=True))


def powers_over(
    flights: Sequence[Mapping[str, float]], instants: int, gusts: Mapping[str, Measure]
) -> dict[str, Measure]:
    """Return mean and deviation of the power of each channel over null flights of so many instants each.

    No deviation is below that of white noise, or below that between flights of other days and pilots. In turbulence
    the channels of the wind triangle are not included.
    """
    turbulent = gusts["level"].mean > np.log(THRESHOLDS.calm_gusts)
    judged = [{n: v for n, v in each.items() if not (turbulent and n in GUSTY)} for each in flights]
    lowest = max(float(np.sqrt(2.0 / instants)), THRESHOLDS.wander_deviation_lowest)
    return measures_over(judged, lowest)


def wandering_channels(
    layout: Layout, before: Layout, null: NullDistribution, explained: float
) -> tuple[Located, ...]:
    """Return the channels that wander more than on null flights, the worst one first.

    `layout` is the log without the named effects, `before` the log with them, and `explained` the fall of the sum
    of squares by them. A channel counts if its surplus over null flights is significant, is more than a share of
    `explained` that an imperfect signature may leave, and is more than half of its surplus before. With the last
    rule a late velocity counts as explained, although its gusts, which no signature contains, are late as well.
    """
    powers, powers_before = channel_powers(layout, null.noise), channel_powers(before, null.noise)
    located = []
    for name, on_null in null.channel_powers.items():
        score = on_null.standardized(powers[name])
        surplus, surplus_before = (
            float(np.exp(each[name]) - np.exp(on_null.mean)) for each in (powers, powers_before)
        )
        is_large = len(layout.grid) * surplus > THRESHOLDS.remaining_share * explained
        is_new = surplus > THRESHOLDS.wander_share * surplus_before
        if score > THRESHOLDS.remaining_wander and is_large and is_new:
            located.append(Located(name, "", "", score))
    return tuple(sorted(located, key=lambda place: -place.significance))
