"""The estimator whose 2σ is meant to cover: generalized least squares against noise with a memory.

The noise (see `linearized`) is white sensor noise plus gusts. Their levels and scale are unknown: they are
estimated by restricted likelihood and marginalized over their posterior.
"""

from dataclasses import dataclass, replace

import numpy as np

from pitotbench.calibrate.gls.linearized_problem import (
    Gusts,
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
from pitotbench.estimate.joint_noise import Noise
from pitotbench.estimate.restricted_likelihood import (
    NoiseNode,
    NoiseOf,
    Regression,
    most_likely_noise,
    noise_posterior,
    solve,
)
from pitotbench.records.calibration import Estimate
from pitotbench.records.errors import NoAnswerError
from pitotbench.units import Array

_LEAST_PLANNED = 10.0  # (m/s²)² s: a second of latency must have moved the airspeed by more than gusts do
_PASSES, _FAR = 6, 4.0  # a step of more standard errors than that is followed by another


@dataclass(frozen=True, slots=True)
class CoveringFit:
    """The reference point θ0 (p + m,), zero for the m nuisances, the noise nodes with corrections to it, and what
    noise was found."""

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
    """Where the first pass ended: θ (p,), the most likely noise, the covariance of θ and the nuisances then."""

    theta: Array
    noise: Array
    covariance: Array


def fit_covering(structure: Structure, obs: Observations, start: Array) -> CoveringFit:
    """Fit from a near-by start θ (p,); every node's estimate is a correction to the returned θ.

    A first pass, on blocks twice as long, moves θ to the most likely noise's answer; the last linearizes there and
    gives the bound.
    """
    return settle(structure, obs, approach(structure, obs, start))


def settle(structure: Structure, obs: Observations, approached: Approach) -> CoveringFit:
    """The last pass of `fit_covering`."""
    length, log_prior = block_length(obs), log_prior_of(structure, obs)
    theta, mode = approached.theta, approached.noise
    blocks = divide(obs, length)
    fine = linearize(structure, obs, blocks, theta, Gusts(*(float(value) for value in np.exp(mode[:2]))))
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
    """The answer for one noise; of a drifting wind, with its mean."""
    mean = mean_wind_under(problem, structure, problem.noise_of(phi), phi)
    return answer if mean is None else mean.of(answer)


def mean_wind_under(problem: Linearized, structure: Structure, noise: Noise, phi: Array) -> MeanWind | None:
    """The mean of a drifting wind under one noise, of parameters φ; None for a wind that does not drift."""
    if problem.kernel is None:
        return None
    deviation, first = float(np.exp(phi[3])), structure.model.error_count
    return mean_wind(noise, problem.regression, problem.kernel, deviation, first)


def linearized(structure: Structure, obs: Observations, theta: Array, gusts: Gusts) -> Linearized:
    """The problem of a structure at θ (p,), on the blocks of `fit_covering`."""
    blocks = divide(obs, block_length(obs))
    return linearize(structure, obs, blocks, theta[: structure.model.count], gusts)


def approach(structure: Structure, obs: Observations, start: Array) -> Approach:
    """The first pass of `fit_covering`; once, or again and again from a start far away."""
    theta, mode, own, log_prior = start, None, structure.model.count, log_prior_of(structure, obs)
    blocks = divide(obs, 2.0 * block_length(obs))
    unknowns = own + noise_count(structure)
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
        # Linearized at the mean wind: the level around which it would drift for ever may be far away.
        step, covariance = _of_mean_wind(structure, rough, mode, answer)
        theta = theta + step[:own]
        if np.all(np.abs(step[:own]) < _FAR * np.sqrt(np.diag(covariance)[:own])):
            return Approach(theta, mode, covariance)
    raise NoAnswerError("the fit does not settle: check the log for gross errors, or choose a simpler model")


def covariance_given(structure: Structure, obs: Observations, blocks: Blocks, theta: Array, phi: Array) -> Array:
    """Covariance of θ and the nuisances, (p + m, p + m), were the noise known, φ = ln(gust deviation [m/s], gust
    length [m], white deviation [m/s]): the inverse information matrix, whatever the response."""
    problem = linearize(structure, obs, blocks, theta)
    return solve(problem.regression, problem.noise_of(phi))[1]


def acceleration_effect(structure: Structure, obs: Observations, fit: CoveringFit, column: Nuisance) -> Estimate:
    """One more nuisance, free, with the noise that is then most likely, on one-second blocks.

    Its instrument is its smoothed column where that is larger than its `deviation`: planned, no answer to gusts.
    """
    blocks, structure = divide(obs, 1.0), replace(structure, crosswind=False, altitude=None)
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
