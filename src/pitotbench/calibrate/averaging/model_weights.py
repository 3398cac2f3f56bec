"""How likely a log makes each thought of the curve, and the answer when none of them is sure.

The curve is described by a fine spline, whose parameters are its values at many knots: every hypothesis is then a
Gaussian prior on them, and all share one linearization, one set of noises and one set of data. Their evidences are
therefore comparable, which restricted likelihoods of models with different terms are not: those leave out different
contrasts of the data. The wind's prior is flat, and the same for all.
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

_NEGLIGIBLE = 1e-6  # weight of a Gaussian that no bound would notice


@dataclass(frozen=True, slots=True)
class Moments:
    """What the data say under one noise: with weights C⁻¹, the products of regressors X, instruments Z and
    response, and log|C|; `log_mass` is the noise's own weight: prior and volume of its node; `mean_wind` is what
    takes the level of a drifting wind to its mean, None for a wind that does not drift.

    Evidence takes the instruments for regressors (response y + Zθ0). With the regressors themselves the noise of
    the GPS, which is in both sides, would speak for bends: where an airplane holds its speed, there is little else.
    """

    normal: Array  # ZᵀC⁻¹X + Π, with the precision Π of what is known of the nuisances
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
    """The moments under one noise of a problem that was linearized at θ0 (p,); `mean_wind` of the same problem."""
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
    """Log of prior times volume of the nodes of a fit's noise: what is left when its likelihood is taken off."""
    likelihoods = [restricted_log_likelihood(fit.problem, fit.noise_of(node.noise)) for node in fit.nodes]
    return np.array([node.log_mass for node in fit.nodes]) - likelihoods


def weigh_models(thoughts: Sequence[Hypothesis], nodes: Sequence[Moments]) -> tuple[Posterior, Array]:
    """The mixture over all hypotheses and noises, and the probability of each hypothesis, (h,).

    The first parameters are the curve's values at the points for which the hypotheses were made.
    """
    evidences = np.empty((len(thoughts), len(nodes)))
    precisions = [_precision(thought, len(nodes[0].gradient)) for thought in thoughts]
    for h, thought in enumerate(thoughts):
        prior = float(np.log(thought.probability)) - 0.5 * float(np.linalg.slogdet(thought.covariance)[1])
        for j, node in enumerate(nodes):
            evidences[h, j] = prior + _log_evidence(node, precisions[h])
    weights = np.exp(evidences - logsumexp(evidences))
    kept = np.argwhere(weights > _NEGLIGIBLE)
    answers = [_posterior(nodes[j], precisions[h]) for h, j in kept]
    shares = np.array([weights[h, j] for h, j in kept])
    answer = Posterior(shares / shares.sum(), np.stack([m for m, _ in answers]), np.stack([c for _, c in answers]))
    return answer, weights.sum(axis=1)


def _precision(thought: Hypothesis, size: int) -> Array:
    own = len(thought.covariance)
    precision = np.zeros((size, size))
    precision[:own, :own] = np.linalg.inv(thought.covariance)
    return precision


def _log_evidence(node: Moments, precision: Array) -> float:
    total = node.spread + precision
    misfit = node.clean_square - float(node.clean_gradient @ np.linalg.solve(total, node.clean_gradient))
    return node.log_mass - 0.5 * (node.log_determinant + float(np.linalg.slogdet(total)[1]) + misfit)


def _posterior(node: Moments, precision: Array) -> tuple[Array, Array]:
    """Mean and covariance by instruments, as in `restricted_likelihood.solve`; of a drifting wind, of its mean."""
    inverse = np.linalg.inv(node.normal + precision)
    covariance = inverse @ (node.spread + precision) @ inverse.T
    answer = (inverse @ node.gradient, 0.5 * (covariance + covariance.T))
    return answer if node.mean_wind is None else node.mean_wind.of(answer)
