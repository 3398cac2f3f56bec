"""How likely a log makes a model: its evidence under the common prior of curves, and the usual criteria beside it.

Restricted likelihoods of models with different terms cannot be compared: each leaves out other contrasts of the
data. With a proper prior N(0, S) on the curve's parameters k and flat ones on what all models share (the wind), the
evidence given the noise φ is, exactly, the restricted likelihood times N(k̂; 0, S + V), where k̂ and V are the
estimate and covariance without the prior; it is then summed over the nodes of φ and the degrees of bending.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from pitotbench.calibrate.covering import CoveringFit
from pitotbench.calibrate.curve_prior import CurvePrior
from pitotbench.calibrate.observations import Observations
from pitotbench.calibrate.output_error import OutputErrorFit
from pitotbench.calibrate.prediction import PredictionModel
from pitotbench.calibrate.result import Answer, answer_of
from pitotbench.estimate.held_out import aicc, bic, held_out_log_density, log_likelihood
from pitotbench.estimate.restricted_likelihood import Regression
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
    """What speaks for a candidate: logarithm of its evidence, greatest log-likelihood, AICc and BIC of the whitened
    residual, log predictive density of every stretch given the others; and its answer under the prior."""

    candidate: Candidate
    answer: Answer
    log_evidence: float
    log_likelihood: float
    aicc: float
    bic: float
    held_out: Array


def judge(candidate: Candidate, obs: Observations, prior: CurvePrior) -> Judgment:
    """Judge a candidate; only differences between candidates of one log mean anything."""
    fit, model = candidate.fit, candidate.model
    precisions = prior.precisions(model.error)
    answer, log_evidence = informed(answer_of(fit), np.array([n.log_mass for n in fit.nodes]), precisions)
    likeliest = fit.noise_of(max(fit.nodes, key=lambda node: node.weight).noise)
    # The residuals are in airspeed; as densities of what was measured they are divided by the slope.
    scale = _log_slopes(candidate, obs)
    best = log_likelihood(fit.problem, likeliest) - float(np.sum(scale))
    free = fit.problem.regressors.shape[1] + len(fit.nodes[0].noise)
    middle = precisions[len(precisions) // 2]
    centered = _from_zero(fit.problem, fit.theta[: model.error_count])
    padded = _padded(middle, centered.regressors.shape[1])
    segment = _segments(fit.blocks)
    return Judgment(
        candidate,
        answer,
        log_evidence - float(np.sum(scale)),
        best,
        aicc(best, free, fit.blocks),
        bic(best, free, fit.blocks),
        held_out_log_density(centered, likeliest, padded, segment) - scale,
    )


def informed(answer: Answer, log_masses: Array, precisions: Array) -> tuple[Answer, float]:
    """Fold a prior around zero on the first parameters into a mixture of Gaussians found without one.

    Parameters: answer of m nodes; log of the nodes' masses, (m,); s precisions, (s, k, k), each as likely.
    Returns the answer, of m·s nodes, and the logarithm of the evidence.
    """
    own = precisions.shape[1]
    masses, means, covariances = [], [], []
    for mass, mean, covariance in zip(log_masses, answer.means, answer.covariances, strict=True):
        for precision in precisions:
            spread = np.linalg.inv(precision) + covariance[:own, :own]
            # Kalman's form of the product of two Gaussians: no inverse of the wind's covariance is needed.
            gain = np.linalg.solve(spread, covariance[:own]).T
            means.append(mean - gain @ mean[:own])
            covariances.append(covariance - gain @ covariance[:own])
            misfit = float(mean[:own] @ np.linalg.solve(spread, mean[:own]))
            masses.append(mass - 0.5 * (np.linalg.slogdet(spread)[1] + misfit) - np.log(len(precisions)))
    log_evidence = float(logsumexp(masses))
    return Answer(np.exp(np.array(masses) - log_evidence), np.stack(means), np.stack(covariances)), log_evidence


def _segments(blocks: int) -> Array:
    return np.arange(blocks) * SEGMENTS // blocks


def _log_slopes(candidate: Candidate, obs: Observations) -> Array:
    """Sum over the blocks of each stretch of the log of the indicated pressure's slope over airspeed."""
    own = candidate.model.count
    slope = candidate.model.predict(candidate.fit.theta[:own], obs).slope
    blocks = np.bincount(_segments(candidate.fit.blocks))
    means = [float(np.mean(np.log(part))) for part in np.array_split(slope, SEGMENTS)]
    return np.asarray(blocks * np.array(means))


def _from_zero(problem: Regression, k: Array) -> Regression:
    """The problem for the error parameters themselves, not for corrections to those at which it was linearized."""
    response = problem.response + problem.regressors[:, : len(k)] @ k
    return Regression(response, problem.regressors, problem.instruments)


def _padded(precision: Array, size: int) -> Array:
    padded = np.zeros((size, size))
    padded[: len(precision), : len(precision)] = precision
    return padded
