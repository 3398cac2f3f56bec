"""How well one or several effects explain a gap, and which of two explanations is the better one."""

from collections.abc import Mapping, Sequence

import numpy as np

from pitotbench.reconcile.decide.normal_equations import Fit

PENALTY = 6.0  # fall of the sum of squares that a further free size must bring: ln n for some 400 free instants


def merit(fit: Fit) -> float:
    """Gain less what the number of sizes buys by chance (Schwarz 1978, the Bayesian information criterion)."""
    return fit.gain - PENALTY * (len(fit.columns) - 1)


def score_candidates(fit: Fit) -> float:
    """The merit as significance [σ]."""
    return float(np.sqrt(max(0.0, merit(fit))))


def usual(found: Sequence[Mapping[str, float]], least: float) -> dict[str, tuple[float, float]]:
    """Mean and deviation over null flights of each measure, the deviation never below `least`."""
    values = {name: [each[name] for each in found] for name in found[0]}
    return {n: (float(np.mean(v)), max(least, float(np.std(v, ddof=1)))) for n, v in values.items()}


def joined(columns: Mapping[str, Sequence[int]], names: Sequence[str]) -> tuple[int, ...]:
    """The columns of several effects."""
    return tuple(c for name in names for c in columns[name])
