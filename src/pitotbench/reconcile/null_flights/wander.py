"""How much a channel wanders, against null flights: what neither an effect nor a place to look explains.

A gap that follows no variable, as an error that swings with a period of its own, leaves every mean where it was; it
shows only in the sum of squares of its channel.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from pitotbench.reconcile.decide.scoring import usual
from pitotbench.reconcile.residuals.layout import Layout, noise_residuals
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.records.verdict import Located

THRESHOLD = 6.4  # deviations: one log in two hundred by Student's t of eight flights, over some twenty channels
GUSTY = ("airspeed_along", "airspeed_across", "airspeed_down")  # judged by gusts.py where there is turbulence
ALLOWED = 0.1  # share of the explained sum of squares that an imperfect signature may leave
SAME = 0.5  # share of a channel's surplus from which what is left is not the rest of what was named
CALM = 0.1  # m/s, deviation of gusts below which the air counts as calm


def powers(layout: Layout, noise: NoiseModel) -> dict[str, float]:
    """Logarithm of the mean square innovation of each channel, nuisances taken out."""
    white = noise.innovations(noise_residuals(layout), layout.grid, layout.residuals.slack)
    used = white[np.any(white != 0.0, axis=1)]
    return dict(zip(layout.residuals.names, np.log(np.mean(used**2, axis=0) + 1e-12).tolist(), strict=True))


def usual_powers(
    found: Sequence[Mapping[str, float]], instants: int, gusts: Mapping[str, tuple[float, float]]
) -> dict[str, tuple[float, float]]:
    """Mean and deviation of each channel's power on null flights, of some instants each; the deviation is never
    below that of white noise."""
    gusty = gusts["level"][0] > np.log(CALM)
    judged = [{n: v for n, v in each.items() if not (gusty and n in GUSTY)} for each in found]
    return usual(judged, float(np.sqrt(2.0 / instants)))


def unexplained(
    layout: Layout, before: Layout, noise: NoiseModel, known: Mapping[str, tuple[float, float]], explained: float
) -> tuple[Located, ...]:
    """Channels that wander more than on null flights, the worst one first, by more than a share of what has been
    explained, a sum of squares, may leave, and by most of what the channel showed `before` that was taken out: a
    velocity that is late follows the gusts as well, which no signature knows."""
    seen, first, found = powers(layout, noise), powers(before, noise), []
    for name, (mean, deviation) in known.items():
        told = (seen[name] - mean) / deviation
        left, shown = (float(np.exp(p[name]) - np.exp(mean)) for p in (seen, first))
        if told > THRESHOLD and len(layout.grid) * left > ALLOWED * explained and left > SAME * shown:
            found.append(Located(name, "", "", told))
    return tuple(sorted(found, key=lambda place: -place.significance))
