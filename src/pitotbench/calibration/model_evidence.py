"""The prior of a curve before the flight, and the usual criteria of a model: AICc, BIC, held-out
data.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from pitotbench.calibration.covering import CoveringFit
from pitotbench.calibration.observations import Observations
from pitotbench.calibration.output_error import OutputErrorFit
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.estimation.evidence import aicc, bic, held_out_log_density, log_likelihood
from pitotbench.estimation.noise import JointNoise, Noise
from pitotbench.estimation.restricted_likelihood import Regression
from pitotbench.pressure_error.models import PressureErrorModel
from pitotbench.records import NoAnswerError
from pitotbench.units import Array

# The prior of a pressure-error curve before the flight: a law of the table plus a departure from
# it. No airplane follows a formula exactly, so each law is a first approximation. Over the flown
# range of ln x the curve is a law plus a sum of orthonormal (Legendre) polynomials from degree 2
# on. Their coefficients are independent and Gaussian and fall as 1/degree², the rate of curves with
# a square-integrable second derivative. The size of the departure is unknown: all sizes of a fixed
# list are equally likely. Where a flight has gaps between its speeds, the departure keeps the bound
# wide there.

LEVEL = 0.06  # Δp/q_c, standard deviation of a curve's level and slope: 4 kt at 130 kt
DEPARTURES = (
    0.0005,
    0.001,
    0.002,
    0.004,
    0.008,
)  # Δp/q_c, root mean square: 0.03 to 0.5 kt at 130 kt
LAWLESS = "spline"  # the model whose law is a straight line in ln x: the rest is departure
_LAWLESS_SHARE = 0.5  # probability that the curve follows no law of the table
_DEGREES = 16  # the next coefficient's deviation is 1/64 of that of degree 2

_QUADRATURE_POINTS = (
    24  # of the quadrature; more than the degrees, so that the projection is well determined
)


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One hypothesis of the curve.

    `name` is the model that serves as the law and `departure` [-] the size of the departure from
    it. `probability` is that before the flight; `covariance` (c, c) [-] is that of the curve's
    values at the requested points.
    """

    name: str
    departure: float
    probability: float
    covariance: Array


def hypotheses(
    laws: Sequence[PressureErrorModel], x: Array, level: float = LEVEL
) -> list[Hypothesis]:
    """Combine every law, and the straight line, with a departure of every size.

    Parameters: laws of the table; x (c,), increasing points, evenly spaced in ln x over the range;
    level [-], the standard deviation of the curve's level and slope. The probabilities of the
    result sum to 1.
    """
    place = np.linspace(-1.0, 1.0, len(x))
    departure = _departure(place)
    families = [(LAWLESS, _LAWLESS_SHARE if laws else 1.0, _of_line(place, level))]
    families += [
        (law.name, (1.0 - _LAWLESS_SHARE) / len(laws), _of_law(law, x, level)) for law in laws
    ]
    return [
        Hypothesis(name, size, share / len(DEPARTURES), family + size**2 * departure)
        for name, share, family in families
        for size in DEPARTURES
    ]


def _departure(place: Array) -> Array:
    """Covariance, at places in [-1, 1], of departures whose root mean square is 1."""
    variance = np.arange(2, _DEGREES, dtype=np.float64) ** -4
    polynomials = _orthonormal(place)[:, 2:]
    return np.asarray((polynomials * variance) @ polynomials.T / variance.sum())


def _of_line(place: Array, level: float) -> Array:
    """Covariance of straight lines at places in [-1, 1]."""
    line = _orthonormal(place)[:, :2]
    return np.asarray(level**2 * line @ line.T)


def _of_law(law: PressureErrorModel, x: Array, level: float) -> Array:
    """Covariance at x of the curves of a law.

    Curves of moderate level and slope, with a bend that falls with the degree, are more likely.
    This does not depend on the scale of the law's terms.
    """
    place, weight = legendre.leggauss(_QUADRATURE_POINTS)
    inner = np.exp(0.5 * np.log(x[0] * x[-1]) + 0.5 * np.log(x[-1] / x[0]) * place)
    coefficients = _orthonormal(place).T @ (0.5 * weight[:, None] * law.basis(inner))
    scaled = coefficients / (level / np.maximum(np.arange(_DEGREES), 1.0) ** 2)[:, None]
    basis = law.basis(x)
    return np.asarray(basis @ np.linalg.solve(scaled.T @ scaled, basis.T))


def _orthonormal(place: Array) -> Array:
    """Legendre polynomials at places in [-1, 1], (n, degrees), each with a mean square of 1."""
    return np.asarray(
        legendre.legvander(place, _DEGREES - 1) * np.sqrt(2.0 * np.arange(_DEGREES) + 1.0)
    )


SEGMENTS = 10  # parts of the log of equal length, each predicted from the others
_POINTS = 24  # over the flown range


@dataclass(frozen=True, slots=True)
class ModelFit:
    """One model of the table, fitted to a log: by output error (`white`) and by the covering
    estimator (`fit`).

    `flown` is the range of x = q_ci/q_ref [-] in the data, without the outermost thousandths.
    """

    name: str
    model: PredictionModel
    flown: tuple[float, float]
    white: OutputErrorFit
    fit: CoveringFit


@dataclass(frozen=True, slots=True)
class Judgment:
    """The criteria of a candidate.

    `log_likelihood` is the greatest one of the whitened residual; AICc and BIC follow from it.
    `held_out` (10,) is the log predictive density of each segment given the others.
    """

    candidate: ModelFit
    log_likelihood: float
    aicc: float
    bic: float
    held_out: Array

    @property
    def unfitness(self) -> float:
        """The mean of two estimates of −2 times the log density of new data: AICc and the held-out
        score.
        """
        return 0.5 * self.aicc - float(np.sum(self.held_out))


def judge_model(candidate: ModelFit, obs: Observations) -> Judgment:
    """Judge a candidate. Only differences between candidates of one log have a meaning.

    Raises NoAnswerError for a fit that turns back, where the indicated pressure falls as the
    airspeed rises.
    """
    fit = candidate.fit
    likeliest, rows = _of_triangle(fit.noise_of(max(fit.nodes, key=lambda node: node.weight).noise))
    # The residuals are in airspeed. A density of the measured pressure is that of the airspeed over
    # the slope.
    scale = _log_slopes(candidate, obs)
    problem = _clean(candidate, rows)
    best = log_likelihood(problem, likeliest) - float(np.sum(scale))
    free = fit.problem.regressors.shape[1] + len(fit.nodes[0].noise)
    segment = _segments(fit.blocks)
    return Judgment(
        candidate,
        best,
        aicc(best, free, fit.blocks),
        bic(best, free, fit.blocks),
        held_out_log_density(problem, likeliest, _weak_prior(candidate), segment) - scale,
    )


def _of_triangle(noise: Noise) -> tuple[Noise, slice]:
    """The noise of the wind triangle's rows, and these rows. The heights do not distinguish the
    models.
    """
    return noise.first if isinstance(noise, JointNoise) else (noise, slice(None))


def _clean(candidate: ModelFit, rows: slice) -> Regression:
    """The problem with the instruments as regressors, as for the evidence (see
    `model_weights.Moments`).

    Its unknowns are the error parameters themselves, not corrections to those at which it was
    linearized.
    """
    problem, free = candidate.fit.problem, candidate.model.error_count
    k = candidate.fit.theta[:free]
    instruments = problem.instruments[rows]
    response = problem.response[rows] + instruments[:, :free] @ k
    return replace(problem, response=response, regressors=instruments, instruments=instruments)


def _weak_prior(candidate: ModelFit) -> Array:
    """A precision that keeps the curve within a few LEVELs at speeds that occur in the held-out
    segment alone.
    """
    free = candidate.model.error_count
    low, high = candidate.flown
    basis = candidate.model.error.basis(np.geomspace(low, high, _POINTS))
    precision = np.diag(candidate.fit.problem.prior_precision)
    precision[:free, :free] = basis.T @ basis * (free / _POINTS / LEVEL**2)
    return precision


def _segments(blocks: int) -> NDArray[np.intp]:
    return np.arange(blocks) * SEGMENTS // blocks


def _log_slopes(candidate: ModelFit, obs: Observations) -> Array:
    """Sum, over the blocks of each segment, of the logarithm of the indicated pressure's slope over
    airspeed.
    """
    count = candidate.model.count
    slope = candidate.model.predict(candidate.fit.theta[:count], obs).slope
    if not np.all(slope > 0.0):
        raise NoAnswerError(
            f"the fit of {candidate.name!r} turns back between the flown speeds: use a simpler "
            "model"
        )
    blocks = np.bincount(_segments(candidate.fit.blocks))
    means = [float(np.mean(np.log(part))) for part in np.array_split(slope, SEGMENTS)]
    return np.asarray(blocks * np.array(means))
