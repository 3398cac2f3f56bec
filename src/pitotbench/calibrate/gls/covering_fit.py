"""The estimator of the covering 2σ: generalized least squares with correlated noise.

The noise (see `linearized_problem`) is white sensor noise plus gusts. Their levels and length are unknown. They are
estimated by restricted likelihood, and the answer is averaged over their posterior.
"""

from dataclasses import dataclass, replace

import numpy as np

from pitotbench.calibrate.gls.linearized_problem import (
    Linearized,
    Structure,
    first_guess,
    linearize,
    log_prior_of,
    noise_count,
    smoothed,
)
from pitotbench.calibrate.model.mean_wind import MeanWind, mean_wind
from pitotbench.calibrate.model.nuisances import Nuisance
from pitotbench.calibrate.rows.blocks import Blocks, block_length, divide
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.estimate.joint_noise import Noise, NoiseOf
from pitotbench.estimate.restricted_likelihood import (
    NoiseNode,
    Regression,
    most_likely_noise,
    noise_posterior,
    solve,
)
from pitotbench.records.calibration import Estimate
from pitotbench.records.errors import NoAnswerError
from pitotbench.units import Array

_LEAST_PLANNED = 10.0  # (m/s²)² s: a second of latency must have moved the airspeed by more than gusts do
_PASSES, _FAR = 6, 4.0  # passes at most; a step of more standard errors than this is followed by another


@dataclass(frozen=True, slots=True)
class CoveringFit:
    """A fit: θ0, the nodes of the noise posterior and the most likely noise.

    `theta` (p + m,) is the reference point θ0, zero for the m nuisances; the nodes hold corrections to it. The
    deviations of gust and drifting wind are in m/s, the gust length in m; `blocks` is the number of blocks.
    """

    theta: Array
    nodes: tuple[NoiseNode, ...]
    gust_deviation: float
    gust_length: float
    wind_deviation: float
    blocks: int
    problem: Regression  # linearized at θ0
    noise_of: NoiseOf


@dataclass(frozen=True, slots=True)
class Approach:
    """The result of the first pass: θ (p,), the most likely noise φ, and the covariance of θ and the nuisances,
    (p + m, p + m)."""

    theta: Array
    noise: Array
    covariance: Array


def fit_covering(structure: Structure, obs: Observations, start: Array) -> CoveringFit:
    """Fit from a nearby start θ (p,). Every node's estimate is a correction to the returned θ.

    The first pass, on blocks twice as long, moves θ to the estimate under the most likely noise. The last pass
    linearizes there and gives the bound.
    Raises NoAnswerError where the log is too short, the fit leaves the model's domain or the steps do not settle.
    """
    return settle(structure, obs, approach(structure, obs, start))


def settle(structure: Structure, obs: Observations, approached: Approach) -> CoveringFit:
    """Run the last pass of `fit_covering`."""
    length, log_prior = block_length(obs), log_prior_of(structure, obs)
    theta, mode = approached.theta, approached.noise
    blocks = divide(obs, length)
    fine = linearize(structure, obs, blocks, theta, gust_variance=float(np.exp(2.0 * mode[0])))
    nodes = noise_posterior(fine.regression, fine.noise_of, log_prior, mode)
    best = max(nodes, key=lambda node: node.weight).noise
    return CoveringFit(
        theta=np.concatenate([theta, np.zeros(len(structure.nuisances))]),
        nodes=tuple(_node_of_mean_wind(structure, fine, node) for node in nodes),
        gust_deviation=float(np.exp(best[0])),
        gust_length=float(np.exp(best[1])),
        wind_deviation=float(np.exp(best[3])) if structure.drifting else 0.0,
        blocks=len(blocks.count),
        problem=fine.regression,
        noise_of=fine.noise_of,
    )


def _node_of_mean_wind(structure: Structure, problem: Linearized, node: NoiseNode) -> NoiseNode:
    estimate, covariance = _of_mean_wind(structure, problem, node.noise, (node.estimate, node.covariance))
    return replace(node, estimate=estimate, covariance=covariance)


def _of_mean_wind(
    structure: Structure, problem: Linearized, phi: Array, answer: tuple[Array, Array]
) -> tuple[Array, Array]:
    """The answer under one noise, with the mean wind where the wind drifts."""
    mean = mean_wind_under(problem, structure, problem.noise_of(phi), phi)
    return answer if mean is None else mean.of(answer)


def mean_wind_under(problem: Linearized, structure: Structure, noise: Noise, phi: Array) -> MeanWind | None:
    """The mean of a drifting wind under the noise of parameters φ (d,); None for a wind that does not drift."""
    if problem.kernel is None:
        return None
    deviation, first = float(np.exp(phi[3])), structure.model.error_count
    return mean_wind(noise, problem.regression, problem.kernel, deviation, first)


def linearized(structure: Structure, obs: Observations, theta: Array, gust_deviation: float) -> Linearized:
    """Linearize the problem of a structure at θ (p,), on the blocks of `fit_covering`; gust deviation [m/s]."""
    blocks = divide(obs, block_length(obs))
    return linearize(structure, obs, blocks, theta[: structure.model.count], gust_deviation**2)


def approach(structure: Structure, obs: Observations, start: Array) -> Approach:
    """Run the first pass of `fit_covering`, repeated from a start (p,) that is far away.

    Raises NoAnswerError where the log is too short for its unknowns or the steps do not settle.
    """
    theta, mode, count, log_prior = start, None, structure.model.count, log_prior_of(structure, obs)
    blocks = divide(obs, 2.0 * block_length(obs))
    unknowns = count + noise_count(structure)
    if len(blocks.count) <= unknowns:
        raise NoAnswerError(
            f"by its clock the log lasts {obs.time[-1] - obs.time[0]:.3g} s, too short for {unknowns} unknowns: "
            "check the unit of the time, or fly longer"
        )
    for _ in range(_PASSES):
        rough = linearize(structure, obs, blocks, theta)
        guess = first_guess(rough, structure) if mode is None else mode
        mode = most_likely_noise(rough.regression, rough.noise_of, log_prior, guess)
        answer = solve(rough.regression, rough.noise_of(mode))
        # The next point has the mean wind: the level of a drifting wind may be far from any wind of the flight.
        step, covariance = _of_mean_wind(structure, rough, mode, answer)
        theta = theta + step[:count]
        if np.all(np.abs(step[:count]) < _FAR * np.sqrt(np.diag(covariance)[:count])):
            return Approach(theta, mode, covariance)
    raise NoAnswerError("the fit does not settle: check the log for gross errors, or choose a simpler model")


def covariance_given(structure: Structure, obs: Observations, blocks: Blocks, theta: Array, phi: Array) -> Array:
    """Covariance of θ and the nuisances, (p + m, p + m), for a known noise.

    φ = ln(gust deviation [m/s], gust length [m], white deviation [m/s]). It is the inverse information matrix and
    does not depend on the response.
    """
    problem = linearize(structure, obs, blocks, theta)
    return solve(problem.regression, problem.noise_of(phi))[1]


def acceleration_effect(structure: Structure, obs: Observations, fit: CoveringFit, column: Nuisance) -> Estimate:
    """Estimate one more nuisance, without a prior, on one-second blocks, and return it with 2σ.

    The noise is the most likely one with this nuisance. Its instrument is its smoothed column where that exceeds
    `column.deviation`: such accelerations are planned and not a response to gusts. 2σ is infinite where there are
    too few of them.
    """
    blocks, structure = divide(obs, 1.0), replace(structure, altitude=None)
    theta = fit.theta[: structure.model.count]
    plain = linearize(structure, obs, blocks, theta)
    added = blocks.mean(column.column(structure.model.predict(theta, obs), obs))
    smooth = smoothed(added, blocks)
    planned = np.where(np.abs(smooth) > column.deviation, smooth, 0.0)
    if float(planned @ planned) < _LEAST_PLANNED:
        return Estimate(column.name, 0.0, float("inf"))
    wider = Regression(
        plain.regression.response,
        np.column_stack([plain.regression.regressors, added]),
        np.column_stack([plain.regression.instruments, planned]),
        np.append(plain.regression.prior_precision, 0.0),
    )
    best = max(fit.nodes, key=lambda node: node.weight).noise
    start = best[: noise_count(structure)]
    mode = most_likely_noise(wider, plain.noise_of, log_prior_of(structure, obs), start)
    estimate, covariance = solve(wider, plain.noise_of(mode))
    return Estimate(column.name, float(estimate[-1]), 2.0 * float(np.sqrt(covariance[-1, -1])))
