"""Linear regression with Markov noise of unknown level and scale: restricted likelihood and its posterior.

y = Xβ + e, e ~ N(0, C(φ)). β is profiled (and its loss of degrees of freedom counted) by the restricted
likelihood (Patterson and Thompson 1971); φ gets a prior, a mode and a handful of nodes around it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, minimize

from pitotbench.estimate.markov_noise import MarkovNoise
from pitotbench.estimate.mixture import composite_design
from pitotbench.records.errors import NoAnswerError
from pitotbench.units import Array

_DIFFERENCE = 0.15  # step for second differences of the log-posterior, in units of ln φ
_SEARCH = 1e-6  # relative change of the log-posterior (hundreds) that ends the search for its mode
_NARROWEST, _WIDEST = 0.05, 1.2  # bounds on a node's standard deviation in ln φ

NoiseOf = Callable[[Array], MarkovNoise]
LogPrior = Callable[[Array], float]


@dataclass(frozen=True, slots=True)
class Regression:
    """The linear problem: response (n,), regressors (n, p), instruments (n, p) (the regressors, or cleaner
    copies of them that do not share their measurement noise)."""

    response: Array
    regressors: Array
    instruments: Array


@dataclass(frozen=True, slots=True)
class NoiseNode:
    """One value φ of the noise parameters, its posterior weight, and β with its covariance given φ."""

    noise: Array
    weight: float
    estimate: Array
    covariance: Array


def restricted_log_likelihood(problem: Regression, noise: MarkovNoise) -> float:
    """The restricted log-likelihood of the residuals (Harville 1974), up to a constant."""
    data = np.concatenate([problem.regressors, problem.response[:, None]], axis=1)
    products = data.T @ noise.weigh(data)
    scale = np.sqrt(np.diag(products))
    # The last row of the factor is the response explained by the regressors and what is left of it.
    pivots = np.diag(np.linalg.cholesky(products / scale[:, None] / scale)) * scale
    log_normal = 2.0 * np.sum(np.log(pivots[:-1]))
    return float(-0.5 * (noise.log_determinant + log_normal + pivots[-1] ** 2))


def solve(problem: Regression, noise: MarkovNoise) -> tuple[Array, Array]:
    """β and its covariance given the noise: instrumental generalized least squares.

    With instruments equal to regressors this is ordinary generalized least squares.
    """
    p = problem.regressors.shape[1]
    weighed = noise.weigh(problem.instruments)
    normal = weighed.T @ problem.regressors
    spread = weighed.T @ problem.instruments
    scale = np.sqrt(np.diag(spread))
    inverse = np.linalg.inv(normal / np.outer(scale, scale)) / np.outer(scale, scale)
    estimate = inverse @ (weighed.T @ problem.response)
    covariance = inverse @ spread @ inverse.T
    return estimate, np.asarray(0.5 * (covariance + covariance.T)).reshape(p, p)


def most_likely_noise(problem: Regression, noise_of: NoiseOf, log_prior: LogPrior, start: Array) -> Array:
    """The mode of the posterior of φ = ln(noise parameters), (d,), searched from `start`.

    Raises NoAnswerError where none is found.
    """

    def cost(phi: Array) -> float:
        return -restricted_log_likelihood(problem, noise_of(phi)) - log_prior(phi)

    limits = Bounds(start - 12.0, start + 8.0)
    result = minimize(cost, start, method="L-BFGS-B", bounds=limits, options={"maxiter": 100, "ftol": _SEARCH})
    if not np.all(np.isfinite(result.x)) or not np.isfinite(result.fun):
        raise NoAnswerError("the noise of this log has no most likely level: look for stuck or constant channels")
    return np.asarray(result.x)


def noise_posterior(
    problem: Regression, noise_of: NoiseOf, log_prior: LogPrior, start: Array
) -> tuple[NoiseNode, ...]:
    """Nodes of the posterior of φ, each with its β; `start` is a first guess of the mode."""

    def log_posterior(phi: Array) -> float:
        return restricted_log_likelihood(problem, noise_of(phi)) + log_prior(phi)

    mode = most_likely_noise(problem, noise_of, log_prior, start)
    design = composite_design(len(mode))
    places = mode + design.points @ _principal_axes(log_posterior, mode).T
    heights = np.array([log_posterior(phi) for phi in places])
    weights = design.weights * np.exp(heights - heights.max())
    weights /= weights.sum()
    answers = [solve(problem, noise_of(phi)) for phi in places]
    return tuple(
        NoiseNode(phi, float(weight), *answer) for phi, weight, answer in zip(places, weights, answers, strict=True)
    )


def _principal_axes(log_posterior: LogPrior, mode: Array) -> Array:
    """Columns: principal axes of the posterior around its mode, one standard deviation long."""
    d, h = len(mode), _DIFFERENCE
    step = np.eye(d) * h
    center = log_posterior(mode)
    curvature = np.empty((d, d))
    for i in range(d):
        curvature[i, i] = (2.0 * center - log_posterior(mode + step[i]) - log_posterior(mode - step[i])) / h**2
        for j in range(i):
            mixed = sum(a * b * log_posterior(mode + a * step[i] + b * step[j]) for a in (1, -1) for b in (1, -1))
            curvature[i, j] = curvature[j, i] = -mixed / (4.0 * h**2)
    values, vectors = np.linalg.eigh(curvature)
    deviations = np.clip(1.0 / np.sqrt(np.maximum(values, 1e-6)), _NARROWEST, _WIDEST)
    return np.asarray(vectors * deviations)
