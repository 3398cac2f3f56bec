"""The estimator whose 2σ is meant to cover: generalized least squares against noise with a memory.

The residual of one-second block means is white sensor noise plus the gust along the flight path. The gust is a
horizontal vector whose two components are first-order Gauss-Markov processes with the length scale of the Dryden
spectrum (MIL-F-8785C; 533 m above 2,000 ft) under a wide prior; a turn sees first one component, then the other.
Levels and scale are unknown: they are estimated by restricted likelihood and marginalized over their posterior.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from pitotbench.calibrate.blocks import Blocks, block_length, divide
from pitotbench.calibrate.mean_wind import kernel_means, of_mean_wind
from pitotbench.calibrate.nuisances import Nuisance
from pitotbench.calibrate.observations import Observations
from pitotbench.calibrate.prediction import PredictionModel
from pitotbench.estimate.markov_noise import MarkovNoise, MarkovProcess
from pitotbench.estimate.restricted_likelihood import (
    LogPrior,
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

GUST_LENGTH = 533.0  # m, Dryden, above 2,000 ft (MIL-F-8785C)
GUST_LENGTH_FACTOR = 1.6  # standard deviation of the prior on it, as a factor
GUST_SCALE = 2.0  # m/s, half-normal prior on the gust's standard deviation
WHITE_SCALE = 0.5  # m/s, half-normal prior on the white part that is not the pressure sensor's
WIND_SCALE = 1.0  # m/s, half-normal prior on a drifting wind's standard deviation
WIND_TIME = 1800.0  # s, its correlation time: longer than most maneuvers, so nearly a random walk
_LEAST_PLANNED = 10.0  # (m/s²)² s: a second of latency must have moved the airspeed by more than gusts do
_PASSES, _FAR = 6, 4.0  # a step of more standard errors than that is followed by another
_LEAST_WHITE = 0.02  # m/s, where the search for the white level begins at least
_WHITE_FLOOR = 1e-8  # (m/s)²: keeps the covariance regular for logs without noise
_SMOOTHING = 3.0  # s, width of the zero-phase filter that makes the instruments


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
class Structure:
    """What is fitted: the prediction, the nuisances beside its parameters, and whether the wind drifts."""

    model: PredictionModel
    nuisances: tuple[Nuisance, ...]
    drifting: bool


@dataclass(frozen=True, slots=True)
class _Linearized:
    """The problem linearized at one θ, in true airspeed [m/s], as block means: the regression, the family of its
    noise, the sensor's part of the noise [(m/s)²], (blocks,), and of a drifting wind each block's correlation with
    the mean."""

    regression: Regression
    noise_of: NoiseOf
    sensor: Array
    kernel: Array | None


def fit_covering(structure: Structure, obs: Observations, start: Array) -> CoveringFit:
    """Fit from a near-by start θ (p,); every node's estimate is a correction to the returned θ.

    A first pass, on blocks twice as long, moves θ to the most likely noise's answer; the last linearizes there and
    gives the bound.
    """
    length = block_length(obs)
    log_prior = _log_prior_of(structure)
    theta, mode = _approach(structure, obs, start, 2.0 * length, log_prior)
    blocks = divide(obs, length)
    fine = _linearize(structure, obs, blocks, theta, gust_variance=float(np.exp(2.0 * mode[0])))
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


def _node_of_mean_wind(structure: Structure, problem: _Linearized, node: NoiseNode) -> NoiseNode:
    estimate, covariance = _of_mean_wind(structure, problem, node.noise, (node.estimate, node.covariance))
    return replace(node, estimate=estimate, covariance=covariance)


def _of_mean_wind(
    structure: Structure, problem: _Linearized, phi: Array, answer: tuple[Array, Array]
) -> tuple[Array, Array]:
    """The answer for one noise; of a drifting wind, with its mean."""
    if problem.kernel is None:
        return answer
    deviation, first = float(np.exp(phi[3])), structure.model.error_count
    return of_mean_wind(answer, problem.noise_of(phi), problem.regression, problem.kernel, deviation, first)


def linearized(structure: Structure, obs: Observations, theta: Array, gust_deviation: float) -> Regression:
    """The problem of a structure at θ (p,), on the blocks of `fit_covering`."""
    blocks = divide(obs, block_length(obs))
    return _linearize(structure, obs, blocks, theta[: structure.model.count], gust_deviation**2).regression


def _approach(
    structure: Structure, obs: Observations, start: Array, length: float, log_prior: LogPrior
) -> tuple[Array, Array]:
    """θ and the most likely noise on blocks of a length [s]; once, or again and again from a start far away."""
    theta, mode, own = start, None, structure.model.count
    blocks = divide(obs, length)
    for _ in range(_PASSES):
        rough = _linearize(structure, obs, blocks, theta)
        guess = _first_guess(rough, structure) if mode is None else mode
        mode = most_likely_noise(rough.regression, rough.noise_of, log_prior, guess)
        answer = solve(rough.regression, rough.noise_of(mode))
        # Linearized at the mean wind: the level around which it would drift for ever may be far away.
        step, covariance = _of_mean_wind(structure, rough, mode, answer)
        theta = theta + step[:own]
        if np.all(np.abs(step[:own]) < _FAR * np.sqrt(np.diag(covariance)[:own])):
            return theta, mode
    raise NoAnswerError("the fit does not settle: check the log for gross errors, or choose a simpler model")


def covariance_given(structure: Structure, obs: Observations, blocks: Blocks, theta: Array, phi: Array) -> Array:
    """Covariance of θ and the nuisances, (p + m, p + m), were the noise known, φ = ln(gust deviation [m/s], gust
    length [m], white deviation [m/s]): the inverse information matrix, whatever the response."""
    problem = _linearize(structure, obs, blocks, theta)
    return solve(problem.regression, problem.noise_of(phi))[1]


def acceleration_effect(structure: Structure, obs: Observations, fit: CoveringFit, column: Nuisance) -> Estimate:
    """One more nuisance, free, with the noise that is then most likely, on one-second blocks.

    Its instrument is its smoothed column where that is larger than its `deviation`: planned, no answer to gusts.
    """
    blocks = divide(obs, 1.0)
    theta = fit.theta[: structure.model.count]
    plain = _linearize(structure, obs, blocks, theta)
    added = blocks.mean(column.column(structure.model.predict(theta, obs), obs))
    smooth = _smoothed(added, blocks)
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
    mode = most_likely_noise(wider, plain.noise_of, _log_prior_of(structure), best)
    estimate, covariance = solve(wider, plain.noise_of(mode))
    return Estimate(column.name, float(estimate[-1]), 2.0 * float(np.sqrt(covariance[-1, -1])))


def _linearize(
    structure: Structure, obs: Observations, blocks: Blocks, theta: Array, gust_variance: float = 0.0
) -> _Linearized:
    """The problem at θ.

    Gusts across the flight path lengthen the airspeed vector: by σ²/V on average, which is taken off.
    """
    prediction = structure.model.predict(theta, obs)
    response = blocks.mean((obs.impact_pressure - prediction.indicated) / prediction.slope)
    columns = [nuisance.column(prediction, obs) for nuisance in structure.nuisances]
    regressors = blocks.mean(np.column_stack([prediction.jacobian / prediction.slope[:, None], *columns]))
    airspeed, slope = blocks.mean(prediction.true_airspeed), blocks.mean(prediction.slope)
    sensor = (_sensor_noise(obs) / slope) ** 2 / blocks.count
    # The residual falls by the wind component along the flight path: these are its direction cosines.
    first = structure.model.error_count
    along = -regressors[:, first : first + 2]
    response -= gust_variance / airspeed
    precision = [0.0] * structure.model.count + [1.0 / n.deviation**2 for n in structure.nuisances]
    return _Linearized(
        Regression(response, regressors, _smoothed(regressors, blocks), np.array(precision)),
        _noise_family(structure, blocks, airspeed, along, sensor),
        sensor,
        kernel_means(blocks, WIND_TIME) if structure.drifting else None,
    )


def _smoothed(regressors: Array, blocks: Blocks) -> Array:
    return np.asarray(gaussian_filter1d(regressors, _SMOOTHING / blocks.length, axis=0, mode="nearest"))


def _sensor_noise(obs: Observations) -> float:
    """White noise of the impact pressure [Pa], from its second differences (slow signals cancel)."""
    second = np.diff(obs.impact_pressure, 2)
    return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6.0))


def _noise_family(structure: Structure, blocks: Blocks, airspeed: Array, along: Array, sensor: Array) -> NoiseOf:
    """φ = ln(gust deviation [m/s], gust length [m], white deviation [m/s] (, slow wind's deviation [m/s])) to a
    covariance."""
    at_edges = blocks.at_edges(airspeed)
    slow = np.full(len(at_edges), WIND_TIME)

    def noise_of(phi: Array) -> MarkovNoise:
        deviation, length, white = np.exp(phi[:3])
        winds = [MarkovProcess(deviation, length / at_edges, along)]
        if structure.drifting:
            winds.append(MarkovProcess(float(np.exp(phi[3])), slow, along))
        return MarkovNoise(blocks.intervals, sensor + white**2 + _WHITE_FLOOR, winds)

    return noise_of


def _log_prior_of(structure: Structure) -> LogPrior:
    """Half-normal levels (the φ terms turn densities of a level into densities of its logarithm), log-normal
    length."""
    scales = [(0, GUST_SCALE), (2, WHITE_SCALE)] + ([(3, WIND_SCALE)] if structure.drifting else [])

    def log_prior(phi: Array) -> float:
        levels = sum(phi[i] - 0.5 * (np.exp(phi[i]) / scale) ** 2 for i, scale in scales)
        length = -0.5 * ((phi[1] - np.log(GUST_LENGTH)) / np.log(GUST_LENGTH_FACTOR)) ** 2
        return float(levels + length)

    return log_prior


def _first_guess(problem: _Linearized, structure: Structure) -> Array:
    """From the residual of least squares: what neighbors share is gust, what is left beside the sensor is white."""
    data = problem.regression
    rest = data.response - data.regressors @ np.linalg.lstsq(data.regressors, data.response)[0]
    total = max(float(np.mean(rest**2)), _WHITE_FLOOR)
    once, twice = (max(float(np.mean(rest[k:] * rest[:-k])), 0.05 * total) for k in (1, 2))
    gust = min(once**2 / twice, total)  # an exponential correlation, carried back to lag zero
    white = max(total - gust - float(np.mean(problem.sensor)), _LEAST_WHITE**2)
    return np.log([np.sqrt(gust), GUST_LENGTH, np.sqrt(white)] + [0.3 * WIND_SCALE] * structure.drifting)
