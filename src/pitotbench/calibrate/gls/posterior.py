"""The answer for θ as a mixture of Gaussians: one a node of the noise posterior."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.calibrate.gls.covering_fit import CoveringFit
from pitotbench.calibrate.output_error import OutputErrorFit
from pitotbench.estimate.mixture import half_width, simultaneous_factor
from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class Posterior:
    """Weighted Gaussian answers for θ: weights (m,), means (m, p), covariances (m, p, p)."""

    weights: Array
    means: Array
    covariances: Array

    @property
    def mean(self) -> Array:
        """The mixture's mean, (p,)."""
        return np.asarray(self.weights @ self.means)

    @property
    def covariance(self) -> Array:
        """The mixture's covariance, (p, p)."""
        offset = self.means - self.mean
        within = np.einsum("m,mpq->pq", self.weights, self.covariances)
        return np.asarray(within + np.einsum("m,mp,mq->pq", self.weights, offset, offset))

    def two_sigma(self, gradient: Array) -> Array:
        """Half-widths of linear functions of θ, gradient (c, p)."""
        means = self.means @ gradient.T
        variances = np.einsum("cp,mpq,cq->mc", gradient, self.covariances, gradient)
        with np.errstate(invalid="ignore"):  # a variance below zero ends as a bound that is refused
            deviations = np.sqrt(variances)
        return half_width(self.weights, means, deviations)

    def simultaneous(self, gradient: Array, bounds: Array) -> Array:
        """Half-widths that hold all at once: the pointwise ones (c,) times one factor."""
        return bounds * simultaneous_factor(self.weights, self.means, self.covariances, gradient, bounds)

    def two_sigma_by(self, place: int, gradient: Array) -> Array:
        """The part of the half-widths, (c,), that not knowing θ[place] contributes: what goes when it is known."""
        covariance = self.covariance
        return 2.0 * np.abs(gradient @ covariance[:, place]) / float(np.sqrt(covariance[place, place]))


def posterior_of(fit: OutputErrorFit | CoveringFit) -> Posterior:
    """The answer of a fit: one Gaussian for output error, a mixture for the covering estimator."""
    if isinstance(fit, OutputErrorFit):
        return Posterior(np.ones(1), fit.theta[None], fit.covariance[None])
    return Posterior(
        np.array([node.weight for node in fit.nodes]),
        fit.theta + np.stack([node.estimate for node in fit.nodes]),
        np.stack([node.covariance for node in fit.nodes]),
    )


def mixed(answers: Sequence[tuple[float, Posterior]]) -> Posterior:
    """One answer of several, each with its probability, for the same unknowns."""
    if len(answers) == 1:
        return answers[0][1]
    total = sum(share for share, _ in answers)
    return Posterior(
        np.concatenate([share / total * answer.weights for share, answer in answers]),
        np.concatenate([answer.means for _, answer in answers]),
        np.concatenate([answer.covariances for _, answer in answers]),
    )
