"""The posterior of θ as a mixture of Gaussians, one per node of the noise posterior."""

from dataclasses import dataclass

import numpy as np

from pitotbench.calibrate.gls.covering_fit import CoveringFit
from pitotbench.calibrate.output_error import OutputErrorFit
from pitotbench.estimate.mixture import half_width, simultaneous_factor
from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class Posterior:
    """Weighted Gaussians for θ: weights (m,), which sum to 1, means (m, p) and covariances (m, p, p)."""

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
        """2σ of linear functions of θ with gradient (c, p), as half-widths of the mixture, (c,)."""
        means = self.means @ gradient.T
        variances = np.einsum("cp,mpq,cq->mc", gradient, self.covariances, gradient)
        with np.errstate(invalid="ignore"):  # a negative variance gives a NaN bound, which `require_useful` refuses
            deviations = np.sqrt(variances)
        return half_width(self.weights, means, deviations)

    def simultaneous(self, gradient: Array, bounds: Array) -> Array:
        """Half-widths that hold at all points together: the pointwise `bounds` (c,) times one factor."""
        return bounds * simultaneous_factor(self.weights, self.means, self.covariances, gradient, bounds)

    def two_sigma_by(self, place: int, gradient: Array) -> Array:
        """The part of 2σ, (c,), that the uncertainty of θ[place] adds: it vanishes where θ[place] is known."""
        covariance = self.covariance
        return 2.0 * np.abs(gradient @ covariance[:, place]) / float(np.sqrt(covariance[place, place]))


def posterior_of(fit: OutputErrorFit | CoveringFit) -> Posterior:
    """The posterior of a fit: one Gaussian for output error, a mixture for the covering estimator."""
    if isinstance(fit, OutputErrorFit):
        return Posterior(np.ones(1), fit.theta[None], fit.covariance[None])
    return Posterior(
        np.array([node.weight for node in fit.nodes]),
        fit.theta + np.stack([node.estimate for node in fit.nodes]),
        np.stack([node.covariance for node in fit.nodes]),
    )
