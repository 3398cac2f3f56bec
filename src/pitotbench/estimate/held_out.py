"""Compare linear models: by the density of held-out data, by the likelihood, and by AICc and BIC.

The density of a held-out stretch s, with the coefficients found from all other data, needs only one factorization
of the whole problem. With P = C⁻¹ − C⁻¹X(XᵀC⁻¹X + Π)⁻¹XᵀC⁻¹, the stretch is Gaussian with precision P_ss and
deviates from its mean by P_ss⁻¹(Py)_s (Dubrule, Cross validation of kriging in a unique neighborhood, 1983). Unlike
restricted likelihoods, such densities compare models with different regressors.
"""

import numpy as np
from numpy.typing import NDArray

from pitotbench.estimate.joint_noise import Noise
from pitotbench.estimate.restricted_likelihood import Regression
from pitotbench.units import Array

_LOG_TWO_PI = float(np.log(2.0 * np.pi))


def held_out_log_density(
    problem: Regression, noise: Noise, prior_precision: Array, segment: NDArray[np.intp]
) -> Array:
    """Return the log predictive density of each stretch given all others, (stretches,).

    Parameters: problem; noise; prior_precision Π of the coefficients around zero, (p, p), zeros for no prior;
    segment, the number of the stretch of each datum, (n,), counted from 0.
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
    """Return the log density of a Gaussian, given its precision and the precision times the deviation."""
    factor = np.linalg.cholesky(0.5 * (precision + precision.T))
    half = np.linalg.solve(factor, projected)
    log_root = float(np.sum(np.log(np.diag(factor))))
    return log_root - 0.5 * float(half @ half) - 0.5 * len(projected) * _LOG_TWO_PI


def log_likelihood(problem: Regression, noise: Noise) -> float:
    """Return the largest log-likelihood over the coefficients for a given noise. Priors of coefficients count."""
    X, y = problem.regressors, problem.response
    weighed = noise.weigh(np.column_stack([X, y]))
    known = problem.prior_precision
    beta = np.linalg.solve(X.T @ weighed[:, :-1] + np.diag(known), X.T @ weighed[:, -1])
    rest = y - X @ beta
    misfit = float(rest @ noise.weigh(rest[:, None])[:, 0]) + float(known @ beta**2)
    return -0.5 * (noise.log_determinant + misfit + len(y) * _LOG_TWO_PI)


def aicc(log_likelihood: float, parameters: int, data: int) -> float:
    """Return Akaike's criterion with the small-sample term (Hurvich and Tsai 1989). Smaller is better."""
    return 2.0 * (parameters - log_likelihood) + 2.0 * parameters * (parameters + 1) / (data - parameters - 1)


def bic(log_likelihood: float, parameters: int, data: int) -> float:
    """Return the Bayesian information criterion (Schwarz 1978). Smaller is better."""
    return parameters * float(np.log(data)) - 2.0 * log_likelihood
