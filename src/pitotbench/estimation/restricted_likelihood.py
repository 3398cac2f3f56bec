"""Linear regression with correlated noise of unknown level and scale, by restricted likelihood.

The posterior of the noise makes the answer a mixture.

y = Xβ + e, e ~ N(0, C(φ)). The restricted likelihood (Patterson and Thompson 1971) eliminates the
coefficients β and accounts for the degrees of freedom that they take. The noise parameters φ have a
prior; their posterior is represented by its mode and a few nodes around it.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import chain, product

import numpy as np

from pitotbench.estimation.noise import JointNoise, JointNoiseOf, Noise, NoiseOf, weighed_by_each
from pitotbench.records import NoAnswerError
from pitotbench.units import Array

_FULL = 5  # dimensions up to which the design has all corners
# weight of a noise with one of several rival priors, below which it is left out
_LEAST_WEIGHT = 1e-4
_STAR = 1.1  # Rue et al. 2009, §6.5: radius factor of the composite design


@dataclass(frozen=True, slots=True)
class Nodes:
    """Design points in whitened coordinates, (m, d), and their weights for a Gaussian, (m,)."""

    points: Array
    weights: Array


def composite_design(dimensions: int) -> Nodes:
    """Return a center, and star and corner points around it, exact for a Gaussian.

    The points lie on a sphere of radius f0·√d; the weights are those that make it exact.

    In three dimensions these are 15 points.
    """
    if dimensions == 0:
        return Nodes(np.zeros((1, 0)), np.ones(1))
    radius = _STAR * np.sqrt(dimensions)
    star = np.concatenate([np.eye(dimensions), -np.eye(dimensions)]) * radius
    corners = _corners(dimensions) * _STAR
    outer = np.concatenate([star, corners]) if dimensions > 1 else star
    # Such that Σ w exp(−|z|²/2) = 1 and Σ w exp(−|z|²/2) |z|² = d: exact moments for a Gaussian
    # posterior.
    center = 1.0 - 1.0 / _STAR**2
    each = np.exp(0.5 * radius**2) / (len(outer) * _STAR**2)
    weights = np.concatenate([[center], np.full(len(outer), each)])
    return Nodes(np.concatenate([np.zeros((1, dimensions)), outer]), weights)


def _corners(dimensions: int) -> Array:
    """Return all corners of a cube up to five dimensions; in more dimensions, sixteen of them.

    The sixteen prefer neither a sum nor a product of two coordinates (a fraction of resolution IV:
    Box, Hunter and Hunter 1978).
    """
    if dimensions <= _FULL:
        return np.array(list(product((-1.0, 1.0), repeat=dimensions)))
    base = np.array(list(product((-1.0, 1.0), repeat=4)))
    a, b, c, d = base.T
    return np.stack([a, b, c, d, a * b * c, b * c * d, a * c * d, a * b * d], axis=1)[
        :, :dimensions
    ]


_DIFFERENCE = 0.03  # step for second differences of the log-posterior, in units of ln φ
_STEPS = 40  # of the search, at most
_HALVINGS = 12  # of a step, at most
# gain in log-posterior below which a step is the last one: the next gains far less
_LEAST_GAIN = 0.1
_ROUGHLY = 0.3  # the same for a mode that another search starts from
_FLATTEST = 0.2  # second derivative below which a direction counts as flat
_LONGEST = 2.0  # step in ln φ
_NARROWEST = 0.05  # least standard deviation of a node in ln φ
_WIDEST = 1.2  # the greatest

_UNDETERMINED = (
    "the log does not determine the answer within its noise: check the clock, the units and the "
    "columns, "
    "or choose a model with fewer parameters"
)

_TOGETHER = 1 << 13  # rows whose noises are made together: their arrays stay in a processor's cache

LogPrior = Callable[[Array], float]
Heights = Callable[[Array], Array]  # of a log-posterior, (b,), at places (b, d)


@dataclass(frozen=True, slots=True)
class Regression:
    """A linear problem: response (n,), regressors, instruments (n, p), prior precision (p,).

    The instruments are the regressors, or smoothed copies that do not share their measurement
    noise. The prior precision of a coefficient is that of a Gaussian around `prior_mean` (p,), zero
    where that is None; 0 means no prior. Precisions (r, p) are those of r rival priors, alike
    likely before the data: such as a size of the coefficients that nobody knows.
    """

    response: Array
    regressors: Array
    instruments: Array
    prior_precision: Array
    prior_mean: Array | None = None

    @property
    def rivals(self) -> Array:
        """The precisions of all rival priors, (r, p)."""
        return np.atleast_2d(self.prior_precision)

    def prior(self, rival: int) -> tuple[Array, Array]:
        """The precision (p,) of a rival prior, and the pull (p,) of its mean."""
        precision = self.rivals[rival]
        mean = np.zeros_like(precision) if self.prior_mean is None else self.prior_mean
        return precision, precision * mean


@dataclass(frozen=True, slots=True)
class NoiseNode:
    """One value φ of the noise parameters, its posterior weight, and β with its covariance given φ.

    `rival` is the number of the prior of β among the rivals. `log_mass` is the logarithm of the
    weight before normalization. The sum of the masses of all nodes is the restricted likelihood
    integrated over φ.
    """

    noise: Array
    weight: float
    log_mass: float
    estimate: Array
    covariance: Array
    rival: int = 0


def restricted_log_likelihood(problem: Regression, noise: Noise) -> float:
    """Return the restricted log-likelihood of the residuals (Harville 1974), up to a constant.

    The instruments stand for the regressors: measurement noise of the regressors is in the response
    as well, and where both meet, fast noise passes for something that the coefficients explain, and
    a noise with too long a memory for the likely one. Raises numpy.linalg.LinAlgError where the
    data do not determine β.
    """
    return float(np.logaddexp.reduce(_by_rival(problem, noise)))


def _by_rival(problem: Regression, noise: Noise) -> Array:
    """The restricted log-likelihood under one noise and each rival prior, less ln r, (r,)."""
    if isinstance(noise, JointNoise):
        products = noise.products()
    else:
        data = _instruments_and_response(problem)
        products = data.T @ noise.weigh(data)
    found = _log_likelihoods(problem, products[None], np.array([noise.log_determinant]))
    return np.asarray(found[0])


def _instruments_and_response(problem: Regression) -> Array:
    return np.concatenate([problem.instruments, problem.response[:, None]], axis=1)


def _log_likelihoods(problem: Regression, products: Array, log_determinants: Array) -> Array:
    """Return the restricted log-likelihoods, (b, r), under each of r rival priors.

    From [Z y]ᵀC⁻¹[Z y], (b, p + 1, p + 1), and ln|C|, (b,), with the probability of a prior, 1/r.
    """
    rivals = range(len(problem.rivals))
    found = [_log_likelihood(problem, products, rival) for rival in rivals]
    return np.asarray(
        np.stack(found, axis=1) - (0.5 * log_determinants[:, None] + np.log(len(rivals)))
    )


def _log_likelihood(problem: Regression, products: Array, rival: int) -> Array:
    # A prior is like one more datum for its coefficient: it adds to the diagonal. Scaling to a unit
    # diagonal keeps the factor accurate for coefficients of very different units.
    precision, pull = problem.prior(rival)
    whole, p = products.copy(), products.shape[1] - 1
    whole[:, np.arange(p), np.arange(p)] += precision
    whole[:, p, :p] += pull
    if problem.prior_mean is not None:
        whole[:, p, p] += pull @ problem.prior_mean
    scale = np.sqrt(np.diagonal(whole, axis1=1, axis2=2))
    # The last pivot of the factor is the root of the residual sum of squares of the response.
    factors = np.linalg.cholesky(whole / scale[:, :, None] / scale[:, None, :])
    pivots = np.diagonal(factors, axis1=1, axis2=2) * scale
    log_normal = 2.0 * np.sum(np.log(pivots[:, :-1]), axis=1)
    known = float(np.sum(np.log(precision[precision > 0.0]))) if len(problem.rivals) > 1 else 0.0
    return np.asarray(-0.5 * (log_normal + pivots[:, -1] ** 2 - known))


def _heights_of(problem: Regression, noise_of: NoiseOf, log_prior: LogPrior) -> Heights:
    """The log-posterior of φ as a function of many, (b, d); −∞ where data do not determine β."""

    def of_each(phis: Array) -> Array:
        try:
            return _weighed(problem, noise_of, phis)[0]
        except np.linalg.LinAlgError:
            if len(phis) == 1:  # the search then tries a shorter step
                return np.full((1, len(problem.rivals)), -np.inf)
            return np.concatenate([of_each(phi[None]) for phi in phis])

    def heights(phis: Array) -> Array:
        found = np.concatenate([of_each(part) for part in _stacks(problem, phis)])
        return np.asarray(
            np.logaddexp.reduce(found, axis=1) + np.array([log_prior(phi) for phi in phis])
        )

    return heights


def _weighed(problem: Regression, noise_of: NoiseOf, phis: Array) -> tuple[Array, Iterable[Array]]:
    """The restricted log-likelihoods, (b, r), for every φ of (b, d), and C⁻¹Z, (n, p), of each.

    Raises numpy.linalg.LinAlgError where the data do not determine β under one of them.
    """
    if isinstance(noise_of, JointNoiseOf):
        noise_of.learn(phis)
        noises = [noise_of(phi) for phi in phis]
        products = np.stack([noise.products() for noise in noises])
        found = _log_likelihoods(
            problem, products, np.array([noise.log_determinant for noise in noises])
        )
        return found, (noise.weighed_instruments() for noise in noises)
    data = _instruments_and_response(problem)
    log_determinants, weighed = weighed_by_each(noise_of, phis, data)
    return _log_likelihoods(problem, data.T @ weighed, log_determinants), weighed[:, :, :-1]


def _stacks(problem: Regression, phis: Array) -> list[Array]:
    """Divide places (b, d) into stacks."""
    together = max(1, _TOGETHER // len(problem.response))
    return [phis[first : first + together] for first in range(0, len(phis), together)]


@dataclass(frozen=True, slots=True)
class Solution:
    """β, (p,), and its covariance, (p, p), under one prior of probability `weight`.

    The prior is one of rivals.
    """

    weight: float
    estimate: Array
    covariance: Array


def solve(problem: Regression, noise: Noise) -> tuple[Array, Array]:
    """Return β, (p,), and its covariance, (p, p), given the noise, under the likeliest prior.

    See `solutions` for the other rival priors. Raises as that does.
    """
    likeliest = max(solutions(problem, noise), key=lambda each: each.weight)
    return likeliest.estimate, likeliest.covariance


def solutions(problem: Regression, noise: Noise) -> list[Solution]:
    """Return the generalized least-squares answers under each rival prior, given the noise.

    With instruments equal to regressors this is ordinary generalized least squares. Raises
    NoAnswerError where the data do not determine β.
    """
    weighed = (
        noise.weighed_instruments()
        if isinstance(noise, JointNoise)
        else noise.weigh(problem.instruments)
    )
    try:
        by_rival = _by_rival(problem, noise) if len(problem.rivals) > 1 else np.zeros(1)
    except np.linalg.LinAlgError as error:
        raise NoAnswerError(_UNDETERMINED) from error
    weights = np.exp(by_rival - np.logaddexp.reduce(by_rival))
    return [
        Solution(float(weight), *_solved(problem, weighed, rival))
        for rival, weight in enumerate(weights)
    ]


def _solved(problem: Regression, weighed: Array, rival: int = 0) -> tuple[Array, Array]:
    """`solve` with the weighed instruments, C⁻¹Z, (n, p)."""
    p = problem.regressors.shape[1]
    precision, pull = problem.prior(rival)
    prior = np.diag(precision)
    normal = weighed.T @ problem.regressors + prior
    spread = weighed.T @ problem.instruments + prior
    scale = np.sqrt(np.diag(spread))
    try:
        inverse = np.linalg.inv(normal / np.outer(scale, scale)) / np.outer(scale, scale)
    except np.linalg.LinAlgError as error:
        raise NoAnswerError(_UNDETERMINED) from error
    estimate = inverse @ (weighed.T @ problem.response + pull)
    covariance = inverse @ spread @ inverse.T
    return estimate, np.asarray(0.5 * (covariance + covariance.T)).reshape(p, p)


def most_likely_noise(
    problem: Regression, noise_of: NoiseOf, log_prior: LogPrior, start: Array
) -> Array:
    """Return the approximate mode of the posterior of φ = ln(noise parameters), (d,), near `start`.

    Raises NoAnswerError where none is found.
    """
    return _climb(_heights_of(problem, noise_of, log_prior), start, _ROUGHLY)[0]


def mode_and_evidence(
    problem: Regression, noise_of: NoiseOf, log_prior: LogPrior, start: Array
) -> tuple[Array, float]:
    """Return the approximate mode of φ, (d,), and ln of the likelihood integrated over φ.

    The likelihood is the restricted one.

    The integral is Laplace's (Tierney and Kadane 1986), up to a constant that problems of the same
    rows share.
    """
    heights = _heights_of(problem, noise_of, log_prior)
    mode, curvature = _climb(heights, start, _ROUGHLY, _first_set(noise_of))
    height = heights(mode[None])[0]
    values = np.clip(np.linalg.eigvalsh(curvature), _WIDEST**-2, _NARROWEST**-2)
    return mode, float(
        height - 0.5 * np.sum(np.log(values)) + 0.5 * len(mode) * np.log(2.0 * np.pi)
    )


def noise_posterior(
    problem: Regression, noise_of: NoiseOf, log_prior: LogPrior, start: Array
) -> tuple[NoiseNode, ...]:
    """Return the nodes of the posterior of φ, each with its β.

    `start` is a first guess of the mode, (d,).

    Raises NoAnswerError where no mode is found, or where the data do not determine β.
    """
    mode, curvature = _climb(
        _heights_of(problem, noise_of, log_prior), start, _LEAST_GAIN, _first_set(noise_of)
    )
    return _nodes(problem, noise_of, log_prior, mode, curvature)


def weighted_noises(
    problems: Sequence[tuple[Regression, NoiseOf]], log_prior: LogPrior, start: Array
) -> tuple[Array, Array]:
    """Return nodes (m, d) of the posterior of a φ that several problems share, and weights (m,).

    The problems share φ alone. The weights add up to one. Raises as `noise_posterior` does.
    """
    heights_of_each = [_heights_of(*problem, lambda _: 0.0) for problem in problems]

    def heights(phis: Array) -> Array:
        prior = np.array([log_prior(phi) for phi in phis])
        return np.asarray(prior + sum(heights_of(phis) for heights_of in heights_of_each))

    places, base, _ = _places(*_climb(heights, start, _LEAST_GAIN))
    return places, _weights(base, heights(places))


def _places(mode: Array, curvature: Array, count: int | None = None) -> tuple[Array, Array, Array]:
    """Return nodes along a mode's axes, (m, d), their base weights, (m,), and the axes, (d, d).

    `count` is the number of parameters of the first set of rows, whose axes are found by
    themselves; None for one set.
    """
    design = composite_design(len(mode))
    axes = _axes_by_set(curvature, count)
    return mode + design.points @ axes.T, design.weights, axes


def _weights(base: Array, heights: Array) -> Array:
    # Relative to the largest height: the exponential of a log-likelihood of thousands would
    # overflow.
    weights = base * np.exp(heights - heights.max())
    return np.asarray(weights / weights.sum())


def _nodes(
    problem: Regression, noise_of: NoiseOf, log_prior: LogPrior, mode: Array, curvature: Array
) -> tuple[NoiseNode, ...]:
    """Return the nodes around a mode, one for each noise and rival prior.

    What is too unlikely is left out; `curvature` is minus the second derivatives at the mode, (d,
    d).
    """
    places, base, axes = _places(mode, curvature, _first_set(noise_of))
    try:  # each noise is factored once, for its height and for its estimate
        found = [_weighed(problem, noise_of, part) for part in _stacks(problem, places)]
    except np.linalg.LinAlgError as error:
        raise NoAnswerError(_UNDETERMINED) from error
    heights = np.concatenate([likelihoods for likelihoods, _ in found])
    heights = heights + np.array([log_prior(phi) for phi in places])[:, None]
    if np.any(np.all(np.isneginf(heights), axis=1)):
        raise NoAnswerError(_UNDETERMINED)
    volume = float(np.linalg.slogdet(axes)[1]) + 0.5 * len(mode) * np.log(2.0 * np.pi)
    masses = np.log(base)[:, None] + heights + volume
    weights = _weights(base[:, None], heights)
    if len(problem.rivals) > 1:
        weights = (
            np.where(weights > _LEAST_WEIGHT, weights, 0.0) / weights[weights > _LEAST_WEIGHT].sum()
        )
    weighed = chain.from_iterable(instruments for _, instruments in found)
    return tuple(
        NoiseNode(
            phi, float(weights[i, r]), float(masses[i, r]), *_solved(problem, instruments, r), r
        )
        for i, (phi, instruments) in enumerate(zip(places, weighed, strict=True))
        for r in range(len(problem.rivals))
        if len(problem.rivals) == 1 or weights[i, r] > 0.0
    )


def _climb(
    heights: Heights, start: Array, enough: float, count: int | None = None
) -> tuple[Array, Array]:
    """Return the maximum of a function of few variables, and minus its second derivatives.

    Newton's method with numerical derivatives; it ends with a step that gains less than `enough`.
    Second derivatives between the first `count` variables and the others are taken as zero. The
    second derivatives are needed anyway, and a quasi-Newton search would take twice the
    evaluations. Raises NoAnswerError where it does not converge.
    """
    place, found = start, _around(heights, start, count)
    for _ in range(_STEPS):
        here, slope, curvature = found
        if not np.all(np.isfinite(curvature)):
            raise NoAnswerError(_UNDETERMINED)
        # Absolute eigenvalues make each step go uphill even where the function is not yet concave.
        values, vectors = np.linalg.eigh(curvature)
        step = vectors @ ((vectors.T @ slope) / np.maximum(np.abs(values), _FLATTEST))
        step *= min(1.0, _LONGEST / float(np.linalg.norm(step)))
        if float(slope @ step) < enough:
            return place + step, curvature
        taken = _uphill(heights, place, here, step, count)
        if taken is None:
            return place, curvature
        place, found = taken
    raise NoAnswerError(
        "the noise of this log has no most likely level: look for stuck or constant channels"
    )


def _uphill(
    heights: Heights, place: Array, here: float, step: Array, count: int | None
) -> tuple[Array, tuple[float, Array, Array]] | None:
    """Take a step, halved until the function grows, and look around there; None without one."""
    there = _around(heights, place + step, count)  # most steps are taken, and all this is one stack
    if np.isfinite(there[0]) and there[0] > here:
        return place + step, there
    for _ in range(1, _HALVINGS):
        step = 0.5 * step
        height = float(heights((place + step)[None])[0])
        if np.isfinite(height) and height > here:
            return place + step, _around(heights, place + step, count)
    return None


def _around(heights: Heights, place: Array, count: int | None) -> tuple[float, Array, Array]:
    """Return the height at a place, its first derivatives (d,), and minus its second ones (d, d).

    The first derivatives are central differences.
    """
    d, h = len(place), _DIFFERENCE
    step = np.eye(d) * h
    pairs = [
        (i, j) for i in range(d) for j in range(count if count is not None and i >= count else 0, i)
    ]
    places = [
        place,
        *(place + step),
        *(place - step),
        *(place + step[i] + step[j] for i, j in pairs),
    ]
    (here,), ahead, behind, both = np.split(heights(np.array(places)), [1, d + 1, 2 * d + 1])
    with np.errstate(invalid="ignore"):
        curvature = np.diag((2.0 * here - ahead - behind) / h**2)
        for (i, j), value in zip(pairs, both, strict=True):
            curvature[i, j] = curvature[j, i] = -((value - ahead[i] - ahead[j] + here) / h**2)
        return float(here), (ahead - behind) / (2.0 * h), curvature


def _first_set(noise_of: NoiseOf) -> int | None:
    """Return the number of parameters of the first of two sets of rows, None for one set."""
    return noise_of.count if isinstance(noise_of, JointNoiseOf) else None


def _axes_by_set(curvature: Array, count: int | None) -> Array:
    """Return the parameters' principal axes, apart for two sets, the first of `count`.

    Two sets of rows share little but the coefficients, and each set's noise is then factored once
    for many nodes.
    """
    if count is None:
        return _principal_axes(curvature)
    axes = np.zeros_like(curvature)
    for own in (slice(None, count), slice(count, None)):
        axes[own, own] = _principal_axes(curvature[own, own])
    return axes


def _principal_axes(curvature: Array) -> Array:
    """Return the posterior's principal axes at its mode, one deviation long, as columns (d, d)."""
    # The limits keep a flat direction from putting nodes at absurd noise levels.
    values, vectors = np.linalg.eigh(curvature)
    deviations = np.clip(1.0 / np.sqrt(np.maximum(values, 1e-6)), _NARROWEST, _WIDEST)
    return np.asarray(vectors * deviations)
