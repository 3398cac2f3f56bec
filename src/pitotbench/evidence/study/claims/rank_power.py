"""The power of a rank test with few ratings and many ties: how often chance passes it, how often the truth does."""

from itertools import permutations

import numpy as np

from pitotbench.evidence.study.study_tables import rank_agreement
from pitotbench.units import Array

_DRAWS, _SEED = 20_000, 83


def by_chance(ratings: Array, above: float) -> float:
    """Return the share [%] of all orders of a measure whose Kendall's τ with the ratings is above a limit."""
    orders = list(permutations(range(len(ratings))))
    agreements = [rank_agreement(np.array(order, dtype=np.float64), ratings) for order in orders]
    return 100.0 * float(np.mean(np.array(agreements) > above))


def best_agreement(ratings: Array) -> float:
    """Return the largest τ that a measure without ties can have with the ratings; ties count as neither."""
    return rank_agreement(np.asarray(ratings) + 1e-3 * np.arange(len(ratings)), ratings)


def power(ratings: Array, above: float, scatter: float) -> float:
    """Return how often [%] τ is above a limit where the measure is the workload itself.

    The ratings are the workload with a normal error of standard deviation `scatter` [ratings]: the opinion of one
    pilot on one day.
    """
    values = np.asarray(ratings, dtype=np.float64)
    drawn = values + scatter * np.random.default_rng(_SEED).standard_normal((_DRAWS, len(values)))
    first, second = np.triu_indices(len(values), 1)
    signs = np.sign(drawn[:, first] - drawn[:, second]) * np.sign(values[first] - values[second])
    return 100.0 * float(np.mean(np.mean(signs, axis=1) > above))
