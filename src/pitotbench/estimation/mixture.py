"""The bounds of a mixture of Gaussians, one for each plausible set of noise parameters.

The noise parameters are unknown. At each of some nodes of their posterior the answer is Gaussian;
the weighted mixture of these is the answer with the noise marginalized (integrated nested Laplace
approximations: Rue, Martino and Chopin 2009; §6.5 for the nodes).
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr, ndtr, ndtri

from pitotbench.units import Array

TWO_SIGMA_SHARE = float(2.0 * ndtr(2.0) - 1.0)  # 95.45 %
_DRAWS = 15000  # of the whole mixture: they give the factor to about half a percent
_DRAW_SEED = 20111
_HALF_WIDTH_STEPS = 60  # at most
_EXACT = 1e-6  # of the variance of a number that is known
_HALF_WIDTH_ERROR = 1e-13  # of the half-width, as a share


def half_width(
    weights: Array, means: Array, deviations: Array, share: float = TWO_SIGMA_SHARE
) -> Array:
    """Return the half-width, (c,), of the interval around a mixture's mean that holds `share`.

    Parameters: weights (m,), with sum 1; means and standard deviations, (m, c), of c quantities.
    """
    # Newton's steps, and halves of the bracket where one would leave it; all quantities are solved
    # together.
    offset = means - weights @ means
    low = np.zeros(means.shape[1])
    high = 12.0 * np.max(deviations + np.abs(offset), axis=0)
    width = -ndtri(0.5 * (1.0 - share)) * np.sqrt(weights @ (deviations**2 + offset**2))
    for _ in range(_HALF_WIDTH_STEPS):
        above, below = (width - offset) / deviations, (-width - offset) / deviations
        missing = share - weights @ (ndtr(above) - ndtr(below))
        low, high = np.where(missing > 0.0, width, low), np.where(missing > 0.0, high, width)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            density = weights @ ((np.exp(-0.5 * above**2) + np.exp(-0.5 * below**2)) / deviations)
            wider = width + missing * np.sqrt(2.0 * np.pi) / density
        inside = (wider > low) & (wider < high)
        last, width = width, np.where(inside, wider, 0.5 * (low + high))
        if np.all(np.abs(width - last) <= _HALF_WIDTH_ERROR * width):
            break
    return np.asarray(width)


def simultaneous_factor(
    weights: Array, means: Array, covariances: Array, gradient: Array, bounds: Array
) -> float:
    """Return the factor, at least 1, by which pointwise bounds must grow to hold at all points.

    They then hold together in `TWO_SIGMA_SHARE` of cases. The factor is that quantile of the
    largest deviation, in units of the bounds, over draws of the mixture with a fixed seed.

    Parameters: weights (m,), means (m, p) and covariances (m, p, p) of the mixture; gradient (c, p)
    of c linear functions; bounds, their pointwise half-widths, (c,).
    """
    # A fixed seed makes the bound of one log the same at every run.
    rng, largest = np.random.default_rng(_DRAW_SEED), []
    offset = (means - weights @ means) @ gradient.T
    seen = np.flatnonzero(np.any(gradient != 0.0, axis=0))  # most unknowns are no part of a curve
    draws = np.rint(_DRAWS * weights).astype(np.intp)
    for node in np.flatnonzero(draws):
        covariance = covariances[node][np.ix_(seen, seen)]
        scale = np.sqrt(np.diag(covariance))
        # The root of a covariance by its eigenvectors: a Cholesky factor fails where rounding makes
        # it singular.
        values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
        root = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
        drawn = gradient[:, seen] @ root @ rng.standard_normal((len(seen), draws[node]))
        deviation = np.abs(offset[node][:, None] + drawn)
        largest.append(np.max(deviation / bounds[:, None], axis=0))
    return max(1.0, float(np.quantile(np.concatenate(largest), TWO_SIGMA_SHARE)))


@dataclass(frozen=True, slots=True)
class Posterior:
    """Weighted Gaussians for θ: weights (m,), means (m, p) and covariances (m, p, p).

    The weights sum to 1.
    """

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

    def not_negative(self, place: int) -> "Posterior":
        """Return the same answer where θ[place] cannot be negative, as with a half-normal prior.

        Each Gaussian keeps the mean and the covariance that its part at θ[place] >= 0 has (Johnson,
        Kotz and Balakrishnan, Continuous Univariate Distributions 1, 1994, §10.1).
        """
        shared = self.covariances[:, :, place]
        deviation = np.sqrt(shared[:, place])
        z = self.means[:, place] / deviation
        ratio = np.exp(-0.5 * z**2 - log_ndtr(z)) / np.sqrt(2.0 * np.pi)
        weights = self.weights * ndtr(z)
        by_deviation = shared / deviation[:, None]
        lost = ratio * (ratio + z)
        return Posterior(
            weights / weights.sum(),
            self.means + by_deviation * ratio[:, None],
            self.covariances
            - lost[:, None, None] * by_deviation[:, :, None] * by_deviation[:, None, :],
        )

    def without(self, place: int) -> "Posterior":
        """Return the same answer where θ[place] is zero, known to a thousandth of its deviation.

        An exact number has no bound.
        """
        shared = self.covariances[:, :, place]
        by_variance = (1.0 - _EXACT) * shared / shared[:, place, None]
        return Posterior(
            self.weights,
            self.means - by_variance * self.means[:, place, None],
            self.covariances - by_variance[:, :, None] * shared[:, None, :],
        )

    def two_sigma(self, gradient: Array) -> Array:
        """2σ of linear functions of θ with gradient (c, p), as half-widths of the mixture, (c,)."""
        means = self.means @ gradient.T
        variances = np.einsum("cp,mpq,cq->mc", gradient, self.covariances, gradient)
        with np.errstate(
            invalid="ignore"
        ):  # a negative variance gives a NaN bound, which `require_useful` refuses
            deviations = np.sqrt(variances)
        return half_width(self.weights, means, deviations)

    def correlation(self, gradient: Array) -> Array:
        """Correlation of the errors of linear functions of θ with gradient (c, p), as (c, c)."""
        covariance = gradient @ self.covariance @ gradient.T
        with np.errstate(invalid="ignore"):  # as above
            deviation = np.sqrt(np.diag(covariance))
            return np.asarray(covariance / np.outer(deviation, deviation))

    def simultaneous(self, gradient: Array, bounds: Array) -> Array:
        """Return half-widths that hold at all points together: `bounds` (c,) times one factor."""
        return bounds * simultaneous_factor(
            self.weights, self.means, self.covariances, gradient, bounds
        )

    def two_sigma_by(self, place: int, gradient: Array, bounds: Array) -> Array:
        """Return the part of the 2σ `bounds`, (c,), by the uncertainty of θ[place], 0 where known.

        The part is the bound times the correlation with θ[place], so that no part exceeds the
        whole.
        """
        covariance = self.covariance
        variance = (
            np.einsum("cp,pq,cq->c", gradient, covariance, gradient) * covariance[place, place]
        )
        shared = np.abs(gradient @ covariance[:, place])
        whole = np.sqrt(np.maximum(variance, np.finfo(np.float64).tiny))
        return np.asarray(bounds * np.clip(shared / whole, 0.0, 1.0))


def mixed(answers: list[tuple[float, Posterior]]) -> Posterior:
    """Combine several answers, each with its probability, in one mixture."""
    total = sum(share for share, _ in answers)
    return Posterior(
        np.concatenate([share / total * answer.weights for share, answer in answers]),
        np.concatenate([answer.means for _, answer in answers]),
        np.concatenate([answer.covariances for _, answer in answers]),
    )
