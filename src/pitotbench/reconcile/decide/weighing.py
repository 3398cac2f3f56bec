"""Weigh one set of effects: its evidence over all sizes, each with a prior over scales and a plausible range."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.special import log_ndtr

from pitotbench.reconcile.decide.evidence import Evidence
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.units import Array

LOWEST = 1e-12  # of a deviation, so that it can be divided by


@dataclass(frozen=True, slots=True)
class Prior:
    """The prior of the sizes of one effect: typical values, plausible ranges and least scales, (k,) each."""

    typical: Array
    low: Array
    high: Array
    least: Array

    def deviations(self, scale: float) -> Array:
        """Return the prior deviation of each size at a scale."""
        return np.asarray(np.maximum(scale, self.least) * self.typical)


@dataclass(frozen=True, slots=True)
class Weighed:
    """A set of effects weighed: the logarithm of its evidence, and its sizes with their covariance."""

    log_evidence: float
    sizes: Array
    covariance: Array


def weigh(evidence: Evidence, columns: Sequence[Sequence[int]], priors: Sequence[Prior]) -> Weighed:
    """Return the evidence of some effects, each with the columns of its sizes, for all their sizes together.

    The prior of an effect's sizes is a mixture of normal distributions, N(0, (λ typical)²), over a ladder of scales
    λ, cut at the plausible range. So no order of magnitude of a size is preferred to another. A size that defines
    its effect has no λ below 1: where it vanishes, the effect is another one of the table.
    """
    scales, used = THRESHOLDS.size_scales, [c for each in columns for c in each]
    if not used:
        return Weighed(0.0, np.zeros(0), np.zeros((0, 0)))
    low, high = (np.concatenate([getattr(p, end) for p in priors]) for end in ("low", "high"))
    ladders = product(*_ladders(evidence, used, priors))
    deviations = np.array(
        [np.concatenate([p.deviations(s) for s, p in zip(chosen, priors, strict=True)]) for chosen in ladders]
    )
    found = [evidence.of(used, each) for each in deviations]
    means, covariances = np.array([f.mean for f in found]), np.array([f.covariance for f in found])
    spread = np.sqrt(np.maximum(np.diagonal(covariances, axis1=1, axis2=2), LOWEST**2))
    inside = _log_inside(means, spread, low, high) - _log_inside(np.zeros_like(means), deviations, low, high)
    logs = np.array([f.log_evidence for f in found]) + inside.sum(axis=1) - len(priors) * np.log(len(scales))
    total = float(np.logaddexp.reduce(logs))
    weights = np.exp(logs - total)
    mean = np.sum(weights[:, None] * means, axis=0)
    covariance = np.sum(weights[:, None, None] * covariances, axis=0)
    return Weighed(total, mean, covariance)


def _ladders(evidence: Evidence, columns: Sequence[int], priors: Sequence[Prior]) -> list[tuple[float, ...]]:
    """The scales to be tried for each effect: all for a single one; else the two next to its size.

    With a smaller scale the prior excludes the size, and a larger one costs only its Occam factor.
    """
    scales = THRESHOLDS.size_scales
    if len(priors) == 1:
        return [scales]
    widest = np.concatenate([p.deviations(scales[-1]) for p in priors])
    sizes, ladders, first = np.abs(evidence.of(columns, widest).mean), [], 0
    for prior in priors:
        ratio = float(np.max(sizes[first : first + len(prior.typical)] / prior.typical))
        nearest = int(np.argmin(np.abs(np.log(np.array(scales)) - np.log(max(ratio, LOWEST)))))
        ladders.append(scales[nearest : nearest + 2])
        first += len(prior.typical)
    return ladders


def _log_inside(mean: Array, spread: Array, low: Array, high: Array) -> Array:
    """Logarithm of the probability that normal numbers lie in their ranges."""
    upper, lower = (high - mean) / spread, (low - mean) / spread
    flip = lower > 0.0  # both in the upper tail: take the mirror image, where the logarithms are exact
    upper, lower = np.where(flip, -lower, upper), np.where(flip, -upper, lower)
    above, below = log_ndtr(upper), log_ndtr(lower)
    return np.asarray(above + np.log1p(-np.exp(np.minimum(below - above, -LOWEST))))
