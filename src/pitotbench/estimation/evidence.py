"""Compare linear models by the evidence for further columns.

The columns' coefficients have a normal prior around zero. With the other coefficients integrated
out, the ratio of the evidences with and without them needs only products of the columns with the
whitened rows (the Schur complement of the normal equations; the evidence of a linear model: Bishop,
Pattern Recognition and Machine Learning, 2006, §3.5), so that many sets of columns and many sizes
of a prior cost one solution with the covariance.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.estimation.noise import Noise
from pitotbench.units import Array

_REGULAR = 1e-9  # added to a correlation: columns of a short log may depend on each other


@dataclass(frozen=True, slots=True)
class EvidencePart:
    """Rows whose noise is independent of that of other parts.

    `response` (n,), `regressors` (n, p) of the fitted coefficients, `further` (n, m) columns, and
    their noise.
    """

    response: Array
    regressors: Array
    further: Array
    noise: Noise


@dataclass(frozen=True, slots=True)
class ColumnEvidence:
    """What the rows say of further columns when the fitted coefficients are integrated out.

    `log_likelihood` is the restricted log-likelihood without them, up to a constant. `pull` (m,)
    and `precision` (m, m) are the gradient and the negative Hessian of the one with them, at zero.
    `moved` (p, m) is the change of the estimates of the fitted coefficients per unit of a further
    one.
    """

    log_likelihood: float
    pull: Array
    precision: Array
    moved: Array

    def log_bayes_factor(self, chosen: NDArray[np.intp], deviations: Array) -> float:
        """The log evidence that the chosen columns (k,) add with prior standard deviations (k,)."""
        return float(self.log_bayes_factors(self.pull[None], chosen, deviations)[0])

    def log_bayes_factors(self, pulls: Array, chosen: NDArray[np.intp], deviations: Array) -> Array:
        """The same for each of other pulls (d, m), such as those of `drawn`; (d,)."""
        precision = self._scaled(chosen, deviations)
        scaled = deviations * pulls[:, chosen]
        explained = np.sum(scaled * np.linalg.solve(precision, scaled.T).T, axis=1)
        return np.asarray(0.5 * (explained - np.linalg.slogdet(precision)[1]))

    def drawn(self, count: int, seed: int) -> Array:
        """Draw the pulls (count, m) of rows in which all further coefficients are zero."""
        scale = np.sqrt(np.maximum(np.diag(self.precision), np.finfo(np.float64).tiny))
        correlation = self.precision / np.outer(scale, scale) + _REGULAR * np.eye(len(scale))
        root = scale[:, None] * np.linalg.cholesky(correlation)
        return np.asarray(np.random.default_rng(seed).standard_normal((count, len(scale))) @ root.T)

    def estimate(self, chosen: NDArray[np.intp], deviations: Array) -> Array:
        """The posterior mean of the chosen columns' coefficients, (k,)."""
        precision = self._scaled(chosen, deviations)
        return np.asarray(deviations * np.linalg.solve(precision, deviations * self.pull[chosen]))

    def covariance(self, chosen: NDArray[np.intp], deviations: Array) -> Array:
        """The posterior covariance of the chosen columns' coefficients, (k, k)."""
        return np.asarray(
            np.linalg.inv(self._scaled(chosen, deviations)) * np.outer(deviations, deviations)
        )

    def _scaled(self, chosen: NDArray[np.intp], deviations: Array) -> Array:
        """Posterior precision of the coefficients in units of their prior deviations."""
        precision = self.precision[np.ix_(chosen, chosen)] * np.outer(deviations, deviations)
        return np.asarray(precision + np.eye(len(chosen)))


def column_evidence(
    parts: Sequence[EvidencePart], prior_precision: Array, prior_pull: Array | None = None
) -> ColumnEvidence:
    """Compute the evidence for further columns; `prior_precision` (p,) is that of the fitted
    coefficients, `prior_pull` (p,) the precision times the prior mean, None for a mean of zero.

    Raises numpy.linalg.LinAlgError where the rows do not determine the fitted coefficients.
    """
    p = len(prior_precision)
    count = p + 1 + parts[0].further.shape[1]
    products, determinant = np.zeros((count, count)), 0.0
    for part in parts:
        data = np.column_stack([part.regressors, part.response, part.further])
        products += data.T @ part.noise.weigh(data)
        determinant += part.noise.log_determinant
    products.flat[: p * count : count + 1] += prior_precision
    if prior_pull is not None:
        products[:p, p] += prior_pull
        products[p, :p] += prior_pull
    scale = np.sqrt(np.diag(products)[:p])
    normal = products[:p, :p] / np.outer(scale, scale)
    root = np.linalg.cholesky(normal)
    explained = np.linalg.solve(root, products[:p, p:] / scale[:, None])
    rest = products[p:, p:] - explained.T @ explained
    determinant += 2.0 * float(np.sum(np.log(np.diag(root)) + np.log(scale)))
    moved = -np.linalg.solve(root.T, explained[:, 1:]) / scale[:, None]
    return ColumnEvidence(
        -0.5 * (determinant + float(rest[0, 0])), rest[1:, 0], rest[1:, 1:], moved
    )
