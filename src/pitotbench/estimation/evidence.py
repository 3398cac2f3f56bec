"""Compare linear models: by evidence for further columns, by held-out data, by AICc and BIC."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.estimation.noise import Noise
from pitotbench.estimation.restricted_likelihood import Regression
from pitotbench.units import Array

# The evidence for further columns beside a fitted problem, without a fit of them. The columns'
# coefficients have a normal prior around zero. With the other coefficients integrated out, the
# ratio of the evidences with and without them needs only products of the columns with the whitened
# rows (the Schur complement of the normal equations; the evidence of a linear model: Bishop,
# Pattern Recognition and Machine Learning, 2006, §3.5), so that many sets of columns and many sizes
# of a prior cost one solution with the covariance.

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


# Compare linear models: by the density of held-out data, by the likelihood, and by AICc and BIC.
# The density of a held-out stretch s, with the coefficients found from all other data, needs only
# one factorization of the whole problem. With P = C⁻¹ − C⁻¹X(XᵀC⁻¹X + Π)⁻¹XᵀC⁻¹, the stretch is
# Gaussian with precision P_ss and deviates from its mean by P_ss⁻¹(Py)_s (Dubrule, Cross validation
# of kriging in a unique neighborhood, 1983). Unlike restricted likelihoods, such densities compare
# models with different regressors.

_LOG_TWO_PI = float(np.log(2.0 * np.pi))


def held_out_log_density(
    problem: Regression, noise: Noise, prior_precision: Array, segment: NDArray[np.intp]
) -> Array:
    """Return the log predictive density of each stretch given all others, (stretches,).

    Parameters: problem; noise; prior_precision Π of the coefficients around zero, (p, p), zeros for
    no prior; segment, the number of the stretch of each datum, (n,), counted from 0.
    """
    # P is never formed: its rows of a stretch come from products with unit vectors.
    X, y = problem.regressors, problem.response
    weighed = noise.weigh(np.column_stack([X, y]))
    inner = np.linalg.inv(X.T @ weighed[:, :-1] + prior_precision)
    projected = weighed[:, -1] - weighed[:, :-1] @ (inner @ (X.T @ weighed[:, -1]))
    scores = []
    for number in range(int(segment[-1]) + 1):
        rows = np.flatnonzero(segment == number)
        unit = np.zeros((len(y), len(rows)))
        unit[rows, np.arange(len(rows))] = 1.0
        regressors = weighed[rows, :-1]
        precision = noise.weigh(unit)[rows] - regressors @ inner @ regressors.T
        scores.append(_log_density(precision, projected[rows]))
    return np.array(scores)


def _log_density(precision: Array, projected: Array) -> float:
    """Return the log density of a Gaussian, given its precision and the precision times the
    deviation.
    """
    factor = np.linalg.cholesky(0.5 * (precision + precision.T))
    half = np.linalg.solve(factor, projected)
    log_root = float(np.sum(np.log(np.diag(factor))))
    return log_root - 0.5 * float(half @ half) - 0.5 * len(projected) * _LOG_TWO_PI


def log_likelihood(problem: Regression, noise: Noise) -> float:
    """Return the largest log-likelihood over the coefficients for a given noise. Priors of
    coefficients count.
    """
    X, y = problem.regressors, problem.response
    weighed = noise.weigh(np.column_stack([X, y]))
    known = problem.prior_precision
    beta = np.linalg.solve(X.T @ weighed[:, :-1] + np.diag(known), X.T @ weighed[:, -1])
    rest = y - X @ beta
    misfit = float(rest @ noise.weigh(rest[:, None])[:, 0]) + float(known @ beta**2)
    return -0.5 * (noise.log_determinant + misfit + len(y) * _LOG_TWO_PI)


def aicc(log_likelihood: float, parameters: int, data: int) -> float:
    """Return Akaike's criterion with the small-sample term (Hurvich and Tsai 1989). Smaller is
    better.
    """
    return 2.0 * (parameters - log_likelihood) + 2.0 * parameters * (parameters + 1) / (
        data - parameters - 1
    )


def bic(log_likelihood: float, parameters: int, data: int) -> float:
    """Return the Bayesian information criterion (Schwarz 1978). Smaller is better."""
    return parameters * float(np.log(data)) - 2.0 * log_likelihood
