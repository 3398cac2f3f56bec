"""Score an explanation: how well one or several effects explain a gap, for the number of their sizes."""

import numpy as np

from pitotbench.reconcile.decide.normal_equations import Fit
from pitotbench.reconcile.decide.thresholds import THRESHOLDS


def merit(fit: Fit) -> float:
    """Return the gain less the gain that further sizes bring by chance.

    Source: the Bayesian information criterion (Schwarz 1978).
    """
    return fit.gain - THRESHOLDS.free_size_penalty * (len(fit.columns) - 1)


def significance(fit: Fit) -> float:
    """Return the merit as a significance [σ]; 0 for a negative merit."""
    return float(np.sqrt(max(0.0, merit(fit))))
