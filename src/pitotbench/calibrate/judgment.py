"""The usual criteria of a model: what its whitened residual costs, and how it predicts what it has not seen."""

from dataclasses import dataclass

import numpy as np

from pitotbench.calibrate.covering import CoveringFit
from pitotbench.calibrate.observations import Observations
from pitotbench.calibrate.output_error import OutputErrorFit
from pitotbench.calibrate.prediction import PredictionModel
from pitotbench.estimate.held_out import aicc, bic, held_out_log_density, log_likelihood
from pitotbench.units import Array

SEGMENTS = 10  # stretches of equal length, each predicted from the others


@dataclass(frozen=True, slots=True)
class Candidate:
    """One model of the table, fitted."""

    name: str
    model: PredictionModel
    white: OutputErrorFit
    fit: CoveringFit


@dataclass(frozen=True, slots=True)
class Judgment:
    """What speaks for a candidate: its greatest log-likelihood, AICc and BIC of the whitened residual, and the log
    predictive density of every stretch given the others, (10,)."""

    candidate: Candidate
    log_likelihood: float
    aicc: float
    bic: float
    held_out: Array


def judge(candidate: Candidate, obs: Observations) -> Judgment:
    """Judge a candidate; only differences between candidates of one log mean anything."""
    fit = candidate.fit
    likeliest = fit.noise_of(max(fit.nodes, key=lambda node: node.weight).noise)
    # The residuals are in airspeed; as densities of what was measured they are divided by the slope.
    scale = _log_slopes(candidate, obs)
    best = log_likelihood(fit.problem, likeliest) - float(np.sum(scale))
    free = fit.problem.regressors.shape[1] + len(fit.nodes[0].noise)
    segment = _segments(fit.blocks)
    return Judgment(
        candidate,
        best,
        aicc(best, free, fit.blocks),
        bic(best, free, fit.blocks),
        held_out_log_density(fit.problem, likeliest, segment) - scale,
    )


def _segments(blocks: int) -> Array:
    return np.arange(blocks) * SEGMENTS // blocks


def _log_slopes(candidate: Candidate, obs: Observations) -> Array:
    """Sum over the blocks of each stretch of the log of the indicated pressure's slope over airspeed."""
    own = candidate.model.count
    slope = candidate.model.predict(candidate.fit.theta[:own], obs).slope
    blocks = np.bincount(_segments(candidate.fit.blocks))
    means = [float(np.mean(np.log(part))) for part in np.array_split(slope, SEGMENTS)]
    return np.asarray(blocks * np.array(means))
