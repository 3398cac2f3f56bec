"""The wind of a long flight, window by window."""

from itertools import pairwise

import numpy as np

from pitotbench.calibration.covering_problem import Linearized, Structure
from pitotbench.calibration.observations import Blocks, Observations
from pitotbench.calibration.wind_path import correlated
from pitotbench.estimation.restricted_likelihood import NoiseNode
from pitotbench.records.calibration import Estimate, WindowWind
from pitotbench.units import Array

_WINDOW = 600.0  # s, the longest window
_SHORTEST_WINDOW = 60.0  # s
_GAP = 60.0  # s: a gap that ends a window


def _windows(blocks: Blocks) -> list[slice]:
    """Divide the blocks into windows of ten minutes or less, none across a gap of a minute."""
    middle = blocks.middle()
    ends = [0, *(np.flatnonzero(np.diff(middle) > _GAP) + 1), len(middle)]
    found = []
    for first, end in pairwise(ends):
        lasting = middle[end - 1] - middle[first]
        if lasting >= _SHORTEST_WINDOW:
            edges = np.linspace(
                middle[first], middle[end - 1], int(np.ceil(lasting / _WINDOW)) + 1
            )[1:-1]
            cuts = [first, *np.searchsorted(middle, edges), end]
            found += [slice(int(a), int(b)) for a, b in pairwise(cuts)]
    return found


def window_winds(
    structure: Structure,
    obs: Observations,
    blocks: Blocks,
    problem: Linearized,
    node: NoiseNode,
    theta: Array,
) -> tuple[WindowWind, ...]:
    """The mean wind of each window under the most likely noise."""
    noise, deviation = problem.noise_of(node.noise), float(np.exp(node.noise[3]))
    first, data = structure.model.error_count, problem.regression
    winds, height_rows = slice(first, first + 2), len(data.response) - len(blocks.count)
    known = np.zeros((2, len(node.estimate)))
    known[:, winds] = np.eye(2)
    changes = np.zeros((len(blocks.count), 2, len(structure.nuisances)))
    for place, nuisance in enumerate(structure.nuisances):
        if nuisance.wind is not None:
            changes[:, nuisance.wind[0], place] = blocks.mean(
                np.broadcast_to(nuisance.wind[1](obs), len(obs))
            )
    height, time = blocks.mean(obs.height()), blocks.mean(obs.time)
    windows, found = _windows(blocks), []
    shares = np.zeros((len(blocks.count), len(windows)))
    for number, window in enumerate(windows):
        shares[window, number] = blocks.count[window] / blocks.count[window].sum()
    kernels = correlated(blocks, structure.priors.slow_wind_s, shares)
    for window, weights, kernel in zip(windows, shares.T, kernels.T, strict=True):
        of_level = known.copy()
        of_level[:, structure.model.count :] = np.einsum("b,ban->an", weights, changes)
        crossed = (
            deviation**2
            * np.append(kernel, np.zeros(height_rows))[:, None]
            * data.regressors[:, winds]
        )
        weighed = noise.weigh(crossed)
        value = theta[winds] + of_level @ node.estimate
        value = value + weighed.T @ (data.response - data.regressors @ node.estimate)
        of_level -= weighed.T @ data.regressors
        unknown = deviation**2 * float(weights @ kernel) * np.eye(2) - crossed.T @ weighed
        covariance = of_level @ node.covariance @ of_level.T + unknown
        north, east = (
            Estimate(axis, float(value[i]), 2.0 * float(np.sqrt(max(covariance[i, i], 0.0))))
            for i, axis in enumerate(("north", "east"))
        )
        span = float(time[window][0]), float(time[window][-1])
        found.append(WindowWind(*span, float(weights @ height), north, east))
    return tuple(found)
