"""The wander that null flights have in the cells of a channel, beyond white noise, pooled over their cells."""

from collections.abc import Mapping, Sequence

import numpy as np

from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution, ScoreScale


def wander_of(null: NullDistribution, channels: Sequence[str]) -> Mapping[str, float]:
    """Return the mean of the squared scores of the cells of each channel on null flights, less 1.

    Both the mean of the scores and their spread count, because a flight of another day, pilot, altitude or loading
    has another mean than the null flights. A few flights determine one cell badly; all cells of a channel together
    determine its wander. Without null flights every channel has a usual one.
    """
    if null.flights == 0:
        return dict.fromkeys(channels, THRESHOLDS.wander_unknown)
    return wander_of_scores(null.scores)


def wander_of_scores(scores: ScoreScale) -> dict[str, float]:
    """Return the same from the scores of null flights."""
    squares: dict[str, list[float]] = {}
    for label, mean in scores.cell_mean.items():
        spread = scores.cell_spread[label]
        squares.setdefault(label.split("|")[0], []).append(mean**2 + spread**2)
    return {name: max(0.0, float(np.mean(values)) - 1.0) for name, values in squares.items()}
