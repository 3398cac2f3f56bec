"""The usual criteria of a model: AICc and BIC of its whitened residual, and its prediction of held-out data."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibrate.averaging.curve_prior import LEVEL
from pitotbench.calibrate.gls.covering_fit import CoveringFit
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.output_error import OutputErrorFit
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.estimate.held_out import aicc, bic, held_out_log_density, log_likelihood
from pitotbench.estimate.joint_noise import JointNoise, Noise
from pitotbench.estimate.restricted_likelihood import Regression
from pitotbench.records.errors import NoAnswerError
from pitotbench.units import Array

SEGMENTS = 10  # parts of the log of equal length, each predicted from the others
_POINTS = 24  # over the flown range


@dataclass(frozen=True, slots=True)
class ModelFit:
    """One model of the table, fitted to a log: by output error (`white`) and by the covering estimator (`fit`).

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

    `log_likelihood` is the greatest one of the whitened residual; AICc and BIC follow from it. `held_out` (10,) is
    the log predictive density of each segment given the others.
    """

    candidate: ModelFit
    log_likelihood: float
    aicc: float
    bic: float
    held_out: Array

    @property
    def unfitness(self) -> float:
        """The mean of two estimates of −2 times the log density of new data: AICc and the held-out score."""
        return 0.5 * self.aicc - float(np.sum(self.held_out))


def judge_model(candidate: ModelFit, obs: Observations) -> Judgment:
    """Judge a candidate. Only differences between candidates of one log have a meaning.

    Raises NoAnswerError for a fit that turns back, where the indicated pressure falls as the airspeed rises.
    """
    fit = candidate.fit
    likeliest, rows = _of_triangle(fit.noise_of(max(fit.nodes, key=lambda node: node.weight).noise))
    # The residuals are in airspeed. A density of the measured pressure is that of the airspeed over the slope.
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
    """The noise of the wind triangle's rows, and these rows. The heights do not distinguish the models."""
    return noise.first if isinstance(noise, JointNoise) else (noise, slice(None))


def _clean(candidate: ModelFit, rows: slice) -> Regression:
    """The problem with the instruments as regressors, as for the evidence (see `model_weights.Moments`).

    Its unknowns are the error parameters themselves, not corrections to those at which it was linearized.
    """
    problem, free = candidate.fit.problem, candidate.model.error_count
    k = candidate.fit.theta[:free]
    instruments = problem.instruments[rows]
    response = problem.response[rows] + instruments[:, :free] @ k
    return replace(problem, response=response, regressors=instruments, instruments=instruments)


def _weak_prior(candidate: ModelFit) -> Array:
    """A precision that keeps the curve within a few LEVELs at speeds that occur in the held-out segment alone."""
    free = candidate.model.error_count
    low, high = candidate.flown
    basis = candidate.model.error.basis(np.geomspace(low, high, _POINTS))
    precision = np.diag(candidate.fit.problem.prior_precision)
    precision[:free, :free] = basis.T @ basis * (free / _POINTS / LEVEL**2)
    return precision


def _segments(blocks: int) -> NDArray[np.intp]:
    return np.arange(blocks) * SEGMENTS // blocks


def _log_slopes(candidate: ModelFit, obs: Observations) -> Array:
    """Sum, over the blocks of each segment, of the logarithm of the indicated pressure's slope over airspeed."""
    count = candidate.model.count
    slope = candidate.model.predict(candidate.fit.theta[:count], obs).slope
    if not np.all(slope > 0.0):
        raise NoAnswerError(
            f"the fit of {candidate.name!r} turns back between the flown speeds: use a simpler model"
        )
    blocks = np.bincount(_segments(candidate.fit.blocks))
    means = [float(np.mean(np.log(part))) for part in np.array_split(slope, SEGMENTS)]
    return np.asarray(blocks * np.array(means))
