"""How far a fixed-speed answer may be off: gusts and sensor noise as the legs themselves show them.

What ground velocity and air data leave over, once airspeed and wind are taken out, is white noise plus the gust
along the flight path, a horizontal first-order Gauss-Markov vector of Dryden's length. Their levels come from all
legs and turns of the log together, by restricted likelihood; each plausible noise is then carried through the
methods' own weights (they are not least squares), and the bound is that of the mixture.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from pitotbench.calibrate.gls.linearized_problem import GUST_LENGTH, GUST_LENGTH_FACTOR, GUST_SCALE, WHITE_SCALE
from pitotbench.calibrate.rows.steady_blocks import SECOND
from pitotbench.estimate.markov_noise import Intervals, MarkovNoise, MarkovProcess
from pitotbench.estimate.mixture import half_width
from pitotbench.estimate.restricted_likelihood import Regression, noise_posterior
from pitotbench.units import Array, Seconds

_FLOOR = 1e-4  # m/s: keeps the covariance regular for legs without noise


@dataclass(frozen=True, slots=True)
class LinearizedGroup:
    """A group around its answer: middle of each second [s], residual of ground against air speed [m/s], (n,), unit
    vector of the flight path, (n, 2), what a residual of 1 m/s in each second does to the answer [V, W_N, W_E],
    (n, 3), and the true airspeed [m/s]."""

    time: Seconds
    residual: Array
    along: Array
    gain: Array
    airspeed: float


def two_sigma(groups: Sequence[LinearizedGroup]) -> list[Array]:
    """2σ of each group's airspeed and wind components [m/s], (3,)."""
    weights, noises = _plausible_noises(groups)
    bounds = []
    for group in groups:
        variances = [np.diag(group.gain.T @ _covariance(group, noise) @ group.gain) for noise in noises]
        bounds.append(half_width(weights, np.zeros((len(weights), 3)), np.sqrt(variances)))
    return bounds


def _plausible_noises(groups: Sequence[LinearizedGroup]) -> tuple[Array, list[Array]]:
    """Weights and ln(gust deviation [m/s], gust length [m], white deviation [m/s]) of the noise's posterior."""
    problem, intervals, along, airspeed = _problem(groups)
    level = float(problem.response.std())
    if level < _FLOOR:  # legs from formulas: there is no noise to be found
        return np.ones(1), [np.log([_FLOOR, GUST_LENGTH, _FLOOR])]

    def noise_of(phi: Array) -> MarkovNoise:
        deviation, length, white = np.exp(phi)
        gust = [MarkovProcess(deviation, length / airspeed, along)]
        return MarkovNoise(intervals, np.full(len(along), white**2 + _FLOOR**2), gust)

    nodes = noise_posterior(problem, noise_of, _log_prior, np.log([level, GUST_LENGTH, 0.3 * level]))
    return np.array([node.weight for node in nodes]), [node.noise for node in nodes]


def _log_prior(phi: Array) -> float:
    """Half-normal levels, flat below, and the length of the covering method, as densities of the logarithms."""
    deviation, white = np.exp(phi[0]), np.exp(phi[2])
    levels = -0.5 * (deviation / GUST_SCALE) ** 2 - 0.5 * (white / WHITE_SCALE) ** 2 + phi[0] + phi[2]
    return float(levels - 0.5 * ((phi[1] - np.log(GUST_LENGTH)) / np.log(GUST_LENGTH_FACTOR)) ** 2)


def _problem(groups: Sequence[LinearizedGroup]) -> tuple[Regression, Intervals, Array, Array]:
    """All groups as one regression in order of time, each with its own airspeed and wind; airspeed at the edges."""
    time = np.concatenate([group.time for group in groups])
    order = np.argsort(time)
    response = np.concatenate([group.residual for group in groups])[order]
    along = np.concatenate([group.along for group in groups])[order]
    own = block_diag(*(np.column_stack([np.ones(len(group.time)), group.along]) for group in groups))[order]
    airspeed = np.concatenate([np.full(len(group.time), group.airspeed) for group in groups])[order]
    left = np.concatenate([[0], np.cumsum(np.where(np.diff(time[order]) < 1.01 * SECOND, 1, 2))])
    edges, at_edges = np.empty(left[-1] + 2), np.empty(left[-1] + 2)
    edges[left + 1], at_edges[left + 1] = time[order] + 0.5 * SECOND, airspeed
    edges[left], at_edges[left] = time[order] - 0.5 * SECOND, airspeed
    return Regression(response, own, own, np.zeros(own.shape[1])), Intervals(edges, left), along, at_edges


def _covariance(group: LinearizedGroup, noise: Array) -> Array:
    """Covariance of a group's block means (n, n): white noise plus the exact mean of the gust over the blocks."""
    deviation, length, white = np.exp(noise)
    a = SECOND * group.airspeed / length
    apart = np.abs(group.time[:, None] - group.time) / SECOND
    memory = np.exp(-a * apart) * 2.0 * (np.cosh(a) - 1.0) / a**2
    np.fill_diagonal(memory, 2.0 * (a - 1.0 + np.exp(-a)) / a**2)
    return np.asarray(deviation**2 * memory * (group.along @ group.along.T) + white**2 * np.eye(len(apart)))
