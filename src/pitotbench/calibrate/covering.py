"""The estimator whose 2σ is meant to cover: generalized least squares against noise with a memory.

The residual of one-second block means is white sensor noise plus the gust along the flight path. The gust is a
horizontal vector whose two components are first-order Gauss-Markov processes with the length scale of the Dryden
spectrum (MIL-F-8785C; 533 m above 2,000 ft) under a wide prior; a turn sees first one component, then the other.
Levels and scale are unknown: they are estimated by restricted likelihood and marginalized over their posterior.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from pitotbench.calibrate.blocks import Blocks, divide
from pitotbench.calibrate.observations import Observations
from pitotbench.calibrate.prediction import PredictionModel
from pitotbench.estimate.markov_noise import MarkovNoise, MarkovProcess
from pitotbench.estimate.restricted_likelihood import (
    NoiseNode,
    NoiseOf,
    Regression,
    most_likely_noise,
    noise_posterior,
    solve,
)
from pitotbench.units import Array

GUST_LENGTH = 533.0  # m, Dryden, above 2,000 ft (MIL-F-8785C)
GUST_LENGTH_FACTOR = 1.6  # standard deviation of the prior on it, as a factor
GUST_SCALE = 2.0  # m/s, half-normal prior on the gust's standard deviation
WHITE_SCALE = 0.5  # m/s, half-normal prior on the white part that is not the pressure sensor's
_WHITE_FLOOR = 1e-8  # (m/s)²: keeps the covariance regular for logs without noise
_SMOOTHING = 3.0  # s, width of the zero-phase filter that makes the instruments


@dataclass(frozen=True, slots=True)
class CoveringFit:
    """The reference point θ0 (p,), the noise nodes with corrections to it, and what noise was found."""

    theta: Array
    nodes: tuple[NoiseNode, ...]
    gust_deviation: float
    gust_length: float
    blocks: int
    problem: Regression  # linearized at θ0
    noise_of: NoiseOf


def fit_covering(model: PredictionModel, obs: Observations, start: Array) -> CoveringFit:
    """Fit from a near-by start θ (p,); every node's estimate is a correction to the returned θ.

    The first pass moves θ to the most likely noise's answer, the second linearizes there and gives the bound.
    """
    blocks = divide(obs)
    problem, noise_of = _block_problem(model, obs, blocks, start)
    mode = most_likely_noise(problem, noise_of, _log_prior, _first_guess(problem))
    theta = start + solve(problem, noise_of(mode))[0]
    problem, noise_of = _block_problem(model, obs, blocks, theta, gust_variance=float(np.exp(2.0 * mode[0])))
    nodes = noise_posterior(problem, noise_of, _log_prior, mode)
    best = max(nodes, key=lambda node: node.weight).noise
    return CoveringFit(
        theta, nodes, float(np.exp(best[0])), float(np.exp(best[1])), len(blocks.count), problem, noise_of
    )


def linearized(
    model: PredictionModel, obs: Observations, theta: Array, gust_deviation: float
) -> tuple[Regression, NoiseOf]:
    """The problem of a model at θ (p,), on the blocks of `fit_covering`, and the family of its noise."""
    return _block_problem(model, obs, divide(obs), theta, gust_variance=gust_deviation**2)


def _block_problem(
    model: PredictionModel, obs: Observations, blocks: Blocks, theta: Array, gust_variance: float = 0.0
) -> tuple[Regression, NoiseOf]:
    """The problem linearized at θ, in true airspeed [m/s], as block means; and the family of its noise.

    Gusts across the flight path lengthen the airspeed vector: by σ²/V on average, which is taken off.
    """
    prediction = model.predict(theta, obs)
    response = blocks.mean((obs.impact_pressure - prediction.indicated) / prediction.slope)
    regressors = blocks.mean(prediction.jacobian / prediction.slope[:, None])
    instruments = gaussian_filter1d(regressors, _SMOOTHING / blocks.length, axis=0, mode="nearest")
    sensor = (_sensor_noise(obs) / blocks.mean(prediction.slope)) ** 2 / blocks.count
    # The residual falls by the wind component along the flight path: these are its direction cosines.
    along = -regressors[:, model.error_count : model.error_count + 2]
    airspeed = blocks.mean(prediction.true_airspeed)
    response -= gust_variance / airspeed
    return Regression(response, regressors, instruments), _noise_family(blocks, airspeed, along, sensor)


def _sensor_noise(obs: Observations) -> float:
    """White noise of the impact pressure [Pa], from its second differences (slow signals cancel)."""
    second = np.diff(obs.impact_pressure, 2)
    return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6.0))


def _noise_family(blocks: Blocks, airspeed: Array, along: Array, sensor: Array) -> NoiseOf:
    """φ = ln(gust deviation [m/s], gust length [m], white deviation [m/s]) to a covariance."""
    at_edges = blocks.at_edges(airspeed)

    def noise_of(phi: Array) -> MarkovNoise:
        deviation, length, white = np.exp(phi)
        gust = [MarkovProcess(deviation, length / at_edges, along)]
        return MarkovNoise(blocks.intervals, sensor + white**2 + _WHITE_FLOOR, gust)

    return noise_of


def _log_prior(phi: Array) -> float:
    """Half-normal levels (the φ terms turn densities of a level into densities of its logarithm), log-normal
    length."""
    deviation, white = np.exp(phi[0]), np.exp(phi[2])
    levels = -0.5 * (deviation / GUST_SCALE) ** 2 - 0.5 * (white / WHITE_SCALE) ** 2 + phi[0] + phi[2]
    length = -0.5 * ((phi[1] - np.log(GUST_LENGTH)) / np.log(GUST_LENGTH_FACTOR)) ** 2
    return float(levels + length)


def _first_guess(problem: Regression) -> Array:
    """From the residual of least squares: what neighbors share is gust, the rest is white."""
    rest = problem.response - problem.regressors @ np.linalg.lstsq(problem.regressors, problem.response)[0]
    total = max(float(np.mean(rest**2)), _WHITE_FLOOR)
    shared = float(np.clip(np.mean(rest[1:] * rest[:-1]), 0.05 * total, 0.98 * total))
    return np.log([np.sqrt(shared), GUST_LENGTH, np.sqrt(total - shared)])
