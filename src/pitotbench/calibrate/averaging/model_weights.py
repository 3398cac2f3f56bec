"""The probability of each hypothesis of the curve given a log, and the answer averaged over the hypotheses.

A fine spline describes the curve; its parameters are the curve's values at many knots. Every hypothesis is a
Gaussian prior of these values. All hypotheses share one linearization, one set of noises and one set of data, so
their evidences can be compared. Restricted likelihoods of models with different terms cannot: each of them leaves
out other contrasts of the data. The wind's prior is flat, and the same for all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from pitotbench.calibrate.averaging.curve_prior import Hypothesis
from pitotbench.calibrate.gls.covering_fit import CoveringFit
from pitotbench.calibrate.gls.posterior import Posterior
from pitotbench.calibrate.model.mean_wind import MeanWind
from pitotbench.estimate.joint_noise import Noise
from pitotbench.estimate.restricted_likelihood import Regression, restricted_log_likelihood
from pitotbench.units import Array

_NEGLIGIBLE = 1e-6  # weight of a Gaussian that changes no bound


@dataclass(frozen=True, slots=True)
class Moments:
    """The sums that a fit needs under one noise of covariance C.

    They are the products, with weights C⁻¹, of regressors X, instruments Z and response y, and log|C|. `log_mass`
    is the logarithm of prior times volume of the noise's node. `mean_wind` converts the level of a drifting wind to
    its mean; it is None for a wind that does not drift.

    The evidence uses the instruments as regressors (response y + Zθ0). The noise of the GPS is both in the
    regressors and in the response; with the regressors themselves it would favor curves with bends, above all where
    the airplane holds its speed.
    """

    normal: Array  # ZᵀC⁻¹X + Π, with the prior precision Π of the nuisances
    spread: Array  # ZᵀC⁻¹Z + Π
    gradient: Array  # ZᵀC⁻¹(y + Xθ0), for the estimate
    clean_gradient: Array  # ZᵀC⁻¹(y + Zθ0), for the evidence
    clean_square: float
    log_determinant: float
    log_mass: float
    mean_wind: MeanWind | None


def moments(
    problem: Regression, theta: Array, noise: Noise, log_mass: float, mean_wind: MeanWind | None = None
) -> Moments:
    """Compute the moments under one noise.

    Parameters: problem, linearized at θ0; theta, θ0 (p,); noise; log_mass, see `noise_masses`; mean_wind, of the
    same problem.
    """
    X, Z = problem.regressors, problem.instruments
    clean = problem.response + Z @ theta
    weighed, weighed_clean = noise.weigh(Z), noise.weigh(clean[:, None])[:, 0]
    known = np.diag(problem.prior_precision)
    whole = replace(problem, response=problem.response + X @ theta)  # of θ itself, not of a correction to θ0
    return Moments(
        normal=weighed.T @ X + known,
        spread=weighed.T @ Z + known,
        gradient=weighed.T @ whole.response,
        clean_gradient=weighed.T @ clean,
        clean_square=float(clean @ weighed_clean),
        log_determinant=noise.log_determinant,
        log_mass=log_mass,
        mean_wind=None if mean_wind is None else replace(mean_wind, problem=whole),
    )


def noise_masses(fit: CoveringFit) -> Array:
    """Logarithm of prior times volume of each node of a fit's noise, (nodes,): its mass without the likelihood."""
    likelihoods = [restricted_log_likelihood(fit.problem, fit.noise_of(node.noise)) for node in fit.nodes]
    return np.array([node.log_mass for node in fit.nodes]) - likelihoods


def weigh_models(hypotheses: Sequence[Hypothesis], nodes: Sequence[Moments]) -> tuple[Posterior, Array]:
    """Return the mixture over all hypotheses and noises, and the probability of each hypothesis, (h,).

    The first parameters of the problem are the curve's values at the points for which the hypotheses were made.
    """
    evidences = np.empty((len(hypotheses), len(nodes)))
    precisions = [_precision(hypothesis, len(nodes[0].gradient)) for hypothesis in hypotheses]
    for h, hypothesis in enumerate(hypotheses):
        prior = float(np.log(hypothesis.probability)) - 0.5 * float(np.linalg.slogdet(hypothesis.covariance)[1])
        for j, node in enumerate(nodes):
            evidences[h, j] = prior + _log_evidence(node, precisions[h])
    weights = np.exp(evidences - logsumexp(evidences))
    kept = np.argwhere(weights > _NEGLIGIBLE)
    answers = [_posterior(nodes[j], precisions[h]) for h, j in kept]
    shares = np.array([weights[h, j] for h, j in kept])
    answer = Posterior(shares / shares.sum(), np.stack([m for m, _ in answers]), np.stack([c for _, c in answers]))
    return answer, weights.sum(axis=1)


def _precision(hypothesis: Hypothesis, size: int) -> Array:
    count = len(hypothesis.covariance)
    precision = np.zeros((size, size))
    precision[:count, :count] = np.linalg.inv(hypothesis.covariance)
    return precision


def _log_evidence(node: Moments, precision: Array) -> float:
    total = node.spread + precision
    misfit = node.clean_square - float(node.clean_gradient @ np.linalg.solve(total, node.clean_gradient))
    return node.log_mass - 0.5 * (node.log_determinant + float(np.linalg.slogdet(total)[1]) + misfit)


def _posterior(node: Moments, precision: Array) -> tuple[Array, Array]:
    """Mean and covariance by instruments, as in `restricted_likelihood.solve`; a drifting wind as its mean."""
    inverse = np.linalg.inv(node.normal + precision)
    covariance = inverse @ (node.spread + precision) @ inverse.T
    answer = (inverse @ node.gradient, 0.5 * (covariance + covariance.T))
    return answer if node.mean_wind is None else node.mean_wind.of(answer)
