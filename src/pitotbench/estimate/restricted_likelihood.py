"""Linear regression with correlated noise of unknown level and scale: restricted likelihood and its posterior.

y = Xβ + e, e ~ N(0, C(φ)). The restricted likelihood (Patterson and Thompson 1971) eliminates the coefficients β
and accounts for the degrees of freedom that they take. The noise parameters φ have a prior; their posterior is
represented by its mode and a few nodes around it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pitotbench.estimate.joint_noise import JointNoise, JointNoiseOf, Noise
from pitotbench.estimate.mixture import composite_design
from pitotbench.records.errors import NoAnswerError
from pitotbench.units import Array

_DIFFERENCE = 0.03  # step for second differences of the log-posterior, in units of ln φ
_STEPS, _HALVINGS = 40, 12
_SETTLED, _ROUGHLY = 0.1, 0.3  # gain in log-posterior below which a step is the last one; the next gains far less
_FLATTEST = 0.2  # second derivative below which a direction counts as flat
_LONGEST = 2.0  # step in ln φ
_NARROWEST, _WIDEST = 0.05, 1.2  # bounds on a node's standard deviation in ln φ

_UNDETERMINED = (
    "the log does not determine the answer within its noise: check the clock, the units and the columns, "
    "or choose a model with fewer parameters"
)

NoiseOf = Callable[[Array], Noise]
LogPrior = Callable[[Array], float]


@dataclass(frozen=True, slots=True)
class Regression:
    """The linear problem: response (n,), regressors (n, p), instruments (n, p), prior precision (p,).

    The instruments are the regressors, or smoothed copies that do not share their measurement noise. The prior
    precision of a coefficient is that of a Gaussian around zero; 0 means no prior.
    """

    response: Array
    regressors: Array
    instruments: Array
    prior_precision: Array


@dataclass(frozen=True, slots=True)
class NoiseNode:
    """One value φ of the noise parameters, its posterior weight, and β with its covariance given φ.

    `log_mass` is the logarithm of the weight before normalization. The sum of the masses of all nodes is the
    restricted likelihood integrated over φ.
    """

    noise: Array
    weight: float
    log_mass: float
    estimate: Array
    covariance: Array


def restricted_log_likelihood(problem: Regression, noise: Noise) -> float:
    """Return the restricted log-likelihood of the residuals (Harville 1974), up to a constant.

    The instruments stand for the regressors: measurement noise of the regressors is in the response as well, and
    where both meet, fast noise passes for something that the coefficients explain, and a noise with too long a
    memory for the likely one.
    Raises numpy.linalg.LinAlgError where the data do not determine β.
    """
    if isinstance(noise, JointNoise):
        products = noise.products()
    else:
        data = np.concatenate([problem.instruments, problem.response[:, None]], axis=1)
        products = data.T @ noise.weigh(data)
    # A prior is like one more datum for its coefficient: it adds to the diagonal. Scaling to a unit diagonal keeps
    # the factor accurate for coefficients of very different units.
    products.flat[: -1 : len(products) + 1] += problem.prior_precision
    scale = np.sqrt(np.diag(products))
    # The last pivot of the factor is the root of the residual sum of squares of the response.
    pivots = np.diag(np.linalg.cholesky(products / scale[:, None] / scale)) * scale
    log_normal = 2.0 * np.sum(np.log(pivots[:-1]))
    return float(-0.5 * (noise.log_determinant + log_normal + pivots[-1] ** 2))


def solve(problem: Regression, noise: Noise) -> tuple[Array, Array]:
    """Return β, (p,), and its covariance, (p, p), given the noise, by generalized least squares with instruments.

    With instruments equal to regressors this is ordinary generalized least squares.
    Raises NoAnswerError where the data do not determine β.
    """
    p = problem.regressors.shape[1]
    weighed = noise.weighed_instruments() if isinstance(noise, JointNoise) else noise.weigh(problem.instruments)
    prior = np.diag(problem.prior_precision)
    normal = weighed.T @ problem.regressors + prior
    spread = weighed.T @ problem.instruments + prior
    scale = np.sqrt(np.diag(spread))
    try:
        inverse = np.linalg.inv(normal / np.outer(scale, scale)) / np.outer(scale, scale)
    except np.linalg.LinAlgError as error:
        raise NoAnswerError(_UNDETERMINED) from error
    estimate = inverse @ (weighed.T @ problem.response)
    covariance = inverse @ spread @ inverse.T
    return estimate, np.asarray(0.5 * (covariance + covariance.T)).reshape(p, p)


def most_likely_noise(problem: Regression, noise_of: NoiseOf, log_prior: LogPrior, start: Array) -> Array:
    """Return the approximate mode of the posterior of φ = ln(noise parameters), (d,), searched from `start`.

    Raises NoAnswerError where none is found.
    """
    return _climb(_log_posterior(problem, noise_of, log_prior), start, _ROUGHLY)[0]


def mode_and_evidence(
    problem: Regression, noise_of: NoiseOf, log_prior: LogPrior, start: Array
) -> tuple[Array, float]:
    """Return the approximate mode of φ, (d,), and the logarithm of the restricted likelihood integrated over φ.

    The integral is Laplace's (Tierney and Kadane 1986), up to a constant that problems of the same rows share.
    """
    mode, curvature = _climb(_log_posterior(problem, noise_of, log_prior), start, _ROUGHLY, _first_set(noise_of))
    height = restricted_log_likelihood(problem, noise_of(mode)) + log_prior(mode)
    values = np.clip(np.linalg.eigvalsh(curvature), _WIDEST**-2, _NARROWEST**-2)
    return mode, float(height - 0.5 * np.sum(np.log(values)) + 0.5 * len(mode) * np.log(2.0 * np.pi))


def noise_posterior(
    problem: Regression, noise_of: NoiseOf, log_prior: LogPrior, start: Array
) -> tuple[NoiseNode, ...]:
    """Return the nodes of the posterior of φ, each with its β. `start` is a first guess of the mode, (d,).

    Raises NoAnswerError where no mode is found, or where the data do not determine β.
    """
    mode, curvature = _climb(_log_posterior(problem, noise_of, log_prior), start, _SETTLED, _first_set(noise_of))
    try:
        return _nodes(problem, noise_of, log_prior, mode, curvature)
    except np.linalg.LinAlgError as error:
        raise NoAnswerError(_UNDETERMINED) from error


def weighted_noises(log_posterior: LogPrior, start: Array) -> tuple[Array, Array]:
    """Values of φ around the mode of any log-posterior, (m, d), and their weights, (m,), which add up to one.

    `log_posterior` returns −inf where the data determine nothing; `start` is a first guess of the mode. Raises
    NoAnswerError where no mode is found.
    """
    places, base, _ = _places(*_climb(log_posterior, start, _SETTLED))
    heights = np.array([log_posterior(phi) for phi in places])
    return places, _weights(base, heights)


def _places(mode: Array, curvature: Array, count: int | None = None) -> tuple[Array, Array, Array]:
    """Return the nodes around a mode, (m, d), their base weights, (m,), and the axes along which they lie, (d, d).

    `count` is the number of parameters of the first set of rows, whose axes are found apart; None for one set.
    """
    design = composite_design(len(mode))
    axes = _axes_by_set(curvature, count)
    return mode + design.points @ axes.T, design.weights, axes


def _weights(base: Array, heights: Array) -> Array:
    # Relative to the largest height: the exponential of a log-likelihood of thousands would overflow.
    weights = base * np.exp(heights - heights.max())
    return np.asarray(weights / weights.sum())


def _nodes(
    problem: Regression, noise_of: NoiseOf, log_prior: LogPrior, mode: Array, curvature: Array
) -> tuple[NoiseNode, ...]:
    """Return the nodes around a mode; `curvature` is minus the second derivatives there, (d, d)."""
    places, base, axes = _places(mode, curvature, _first_set(noise_of))
    noises = [noise_of(phi) for phi in places]
    heights = np.array(
        [
            restricted_log_likelihood(problem, noise) + log_prior(phi)
            for noise, phi in zip(noises, places, strict=True)
        ]
    )
    volume = float(np.linalg.slogdet(axes)[1]) + 0.5 * len(mode) * np.log(2.0 * np.pi)
    masses = np.log(base) + heights + volume
    return tuple(
        NoiseNode(phi, float(weight), float(mass), *solve(problem, noise))
        for phi, weight, mass, noise in zip(places, _weights(base, heights), masses, noises, strict=True)
    )


def _log_posterior(problem: Regression, noise_of: NoiseOf, log_prior: LogPrior) -> LogPrior:
    def log_posterior(phi: Array) -> float:
        try:
            return restricted_log_likelihood(problem, noise_of(phi)) + log_prior(phi)
        except np.linalg.LinAlgError:
            return -np.inf  # the search then tries a shorter step

    return log_posterior


def _climb(function: LogPrior, start: Array, enough: float, count: int | None = None) -> tuple[Array, Array]:
    """Return the maximum of a smooth function of few variables, and minus its second derivatives there.

    Newton's method with numerical derivatives; it ends with a step that gains less than `enough`. Second
    derivatives between the first `count` variables and the others are taken as zero. The second derivatives are
    needed anyway, and a quasi-Newton search would take twice the evaluations. Raises NoAnswerError where it does
    not converge.
    """
    place, here = start, function(start)
    for _ in range(_STEPS):
        with np.errstate(invalid="ignore"):
            slope, curvature = _derivatives(function, place, here, count)
        if not np.all(np.isfinite(curvature)):
            raise NoAnswerError(_UNDETERMINED)
        # Absolute eigenvalues make each step go uphill even where the function is not yet concave.
        values, vectors = np.linalg.eigh(curvature)
        step = vectors @ ((vectors.T @ slope) / np.maximum(np.abs(values), _FLATTEST))
        step *= min(1.0, _LONGEST / float(np.linalg.norm(step)))
        if float(slope @ step) < enough:
            return place + step, curvature
        before = here
        place, here = _uphill(function, place, here, step)
        if here <= before:
            return place, curvature
    raise NoAnswerError("the noise of this log has no most likely level: look for stuck or constant channels")


def _uphill(function: LogPrior, place: Array, here: float, step: Array) -> tuple[Array, float]:
    """Take a step, halved until the function grows; take none where no such step is found."""
    for _ in range(_HALVINGS):
        there = function(place + step)
        if np.isfinite(there) and there > here:
            return place + step, there
        step = 0.5 * step
    return place, here


def _derivatives(function: LogPrior, place: Array, here: float, count: int | None) -> tuple[Array, Array]:
    """Return the central first derivatives, (d,), and minus the second derivatives, (d, d)."""
    d, h = len(place), _DIFFERENCE
    step = np.eye(d) * h
    ahead = np.array([function(place + step[i]) for i in range(d)])
    behind = np.array([function(place - step[i]) for i in range(d)])
    curvature = np.diag((2.0 * here - ahead - behind) / h**2)
    for i in range(d):
        for j in range(count if count is not None and i >= count else 0, i):
            both = function(place + step[i] + step[j])
            mixed = (both - ahead[i] - ahead[j] + here) / h**2
            curvature[i, j] = curvature[j, i] = -mixed
    return (ahead - behind) / (2.0 * h), curvature


def _first_set(noise_of: NoiseOf) -> int | None:
    """Return the number of parameters of the first of two sets of rows; None where there is one set."""
    return noise_of.count if isinstance(noise_of, JointNoiseOf) else None


def _axes_by_set(curvature: Array, count: int | None) -> Array:
    """Return the principal axes of the first `count` parameters and of the others, each set separately.

    Two sets of rows share little but the coefficients, and each set's noise is then factored once for many nodes.
    """
    if count is None:
        return _principal_axes(curvature)
    axes = np.zeros_like(curvature)
    for own in (slice(None, count), slice(count, None)):
        axes[own, own] = _principal_axes(curvature[own, own])
    return axes


def _principal_axes(curvature: Array) -> Array:
    """Return the principal axes of the posterior at its mode, one standard deviation long, as columns (d, d)."""
    # The limits keep a flat direction from putting nodes at absurd noise levels.
    values, vectors = np.linalg.eigh(curvature)
    deviations = np.clip(1.0 / np.sqrt(np.maximum(values, 1e-6)), _NARROWEST, _WIDEST)
    return np.asarray(vectors * deviations)
