"""Errors that swing with a period of their own: a line in the spectrum of what nothing explains.

An error that follows no phase of flight and no variable leaves every mean where it was, and beneath gusts it adds
little to the sum of squares; but all of it stands at one frequency (Schuster 1898, the periodogram). Each channel
is looked at without what the others tell of it, so that gusts, which all of them feel, hide less.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from pitotbench.reconcile.decide.scoring import usual
from pitotbench.reconcile.residuals.layout import Layout, noise_residuals
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.records.verdict import Located

THRESHOLD = 6.4  # deviations: one log in two hundred by Student's t of eight flights, over some twenty channels
ALLOWED = 0.1  # share of the explained sum of squares that an imperfect signature may leave at one frequency
SLOWEST = 3  # periods in a log, from which an error is said to swing
LEAST = 0.22  # deviation of the logarithm of the largest of some 300 exponential numbers (Gumbel 1958)


def swings(layout: Layout, noise: NoiseModel) -> dict[str, tuple[float, float]]:
    """The strongest line of each channel: the logarithm of its power, a fall of the sum of squares, and its period
    [s]."""
    seen = noise.innovations(noise_residuals(layout), layout.grid, layout.residuals.slack)
    white = noise.given_others(seen)
    power = 2.0 * np.abs(np.fft.rfft(white, axis=0)) ** 2 / len(white)
    period = len(white) * layout.grid.step / np.maximum(np.arange(len(power)), 1)
    power[:SLOWEST] = 0.0
    best = power.argmax(axis=0)
    found = zip(layout.residuals.names, best, strict=True)
    return {n: (float(np.log(power[k, i] + 1e-12)), float(period[k])) for i, (n, k) in enumerate(found)}


def usual_swings(found: Sequence[Mapping[str, tuple[float, float]]]) -> dict[str, tuple[float, float]]:
    """Mean and deviation of each channel's strongest line on null flights."""
    return usual([{name: value for name, (value, _) in each.items()} for each in found], LEAST)


def swinging(
    layout: Layout, noise: NoiseModel, known: Mapping[str, tuple[float, float]], explained: float
) -> tuple[Located, ...]:
    """Channels with a line that null flights do not have, the worst one first, stronger than a share of what has
    been explained, a sum of squares, may leave."""
    seen, found = swings(layout, noise), []
    for name, (mean, deviation) in known.items():
        value, period = seen[name]
        told = (value - mean) / deviation
        if told > THRESHOLD and np.exp(value) > ALLOWED * explained:
            found.append(Located(name, "", f"a period of {period:.0f} s", told))
    return tuple(sorted(found, key=lambda place: -place.significance))
