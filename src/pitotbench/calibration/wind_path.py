"""A wind that drifts: its path around which a problem is linearized, and its mean."""

from dataclasses import dataclass, replace

import numpy as np

from pitotbench.calibration.observations import Blocks, Observations
from pitotbench.estimation.noise import Noise
from pitotbench.estimation.restricted_likelihood import Regression
from pitotbench.units import Array, Seconds


@dataclass(frozen=True, slots=True)
class WindPath:
    """The wind less its mean around which a problem is linearized: times (k,) [s], (k, 2) [m/s].

    A wind that drifts far is no small correction to its mean; each pass estimates the path again.
    """

    time: Seconds
    wind: Array

    def at(self, time: Seconds) -> Array:
        """The wind toward north and east at times (n,), (n, 2) [m/s]."""
        return np.stack([np.interp(time, self.time, part) for part in self.wind.T], axis=1)

    def taken_from(self, obs: Observations) -> Observations:
        """The rows with ground velocities less the path, as for a constant wind."""
        north, east = self.at(obs.time).T
        return replace(
            obs,
            velocity_north=obs.velocity_north - north,
            velocity_east=obs.velocity_east - east,
            held_north=obs.held_north - north,
            held_east=obs.held_east - east,
        )


# Error of treating blocks as points, as a share of the process's variance: 0.7 cm/s at 1 m/s.
_COARSE = 5e-5


def kernel_means(blocks: Blocks, correlation_time: float) -> Array:
    """Correlation of the process in each block with its mean over all rows, (blocks,) [-].

    `correlation_time` [s] is that of the process.
    """
    return correlated(blocks, correlation_time, (blocks.count / blocks.count.sum())[:, None])[:, 0]


def correlated(blocks: Blocks, correlation_time: float, values: Array) -> Array:
    """Multiply values of the blocks, (blocks, m), by the process's correlations (blocks, blocks).

    A pass forward and one backward take the place of the matrix, which for a long flight would be
    large.
    """
    decay = np.exp(-np.diff(blocks.middle()) / correlation_time)
    forward, backward = values.copy(), values.copy()
    for row, share in enumerate(decay, start=1):
        forward[row] += share * forward[row - 1]
    for row in range(len(values) - 2, -1, -1):
        backward[row] += decay[row] * backward[row + 1]
    return np.asarray(forward + backward - values)


@dataclass(frozen=True, slots=True)
class MeanWind:
    """The map from an answer for the wind's level to one for its mean, under one noise.

    `winds` are the wind's columns among the coefficients. `weighed` (n, 2) is the transpose of G
    C⁻¹. `unknown` (2, 2) [(m/s)²] is the covariance of the mean, given the data and the level.
    """

    winds: slice
    problem: Regression
    weighed: Array
    unknown: Array

    def of(self, answer: tuple[Array, Array]) -> tuple[Array, Array]:
        """Return the answer with the mean wind in place of the wind's level.

        `answer` is an estimate (p,) and its covariance (p, p), and so is the result.
        """
        response, regressors = self.problem.response, self.problem.regressors
        estimate, covariance = answer[0].copy(), answer[1]
        estimate[self.winds] += self.weighed.T @ (response - regressors @ answer[0])
        known = np.eye(len(estimate))
        known[self.winds] -= self.weighed.T @ regressors
        covariance = known @ covariance @ known.T
        covariance[self.winds, self.winds] += self.unknown
        return estimate, 0.5 * (covariance + covariance.T)


def mean_wind(
    noise: Noise, problem: Regression, kernel: Array, deviation: float, first: int
) -> MeanWind:
    """Return the mean wind of a problem whose wind columns begin at `first`.

    The mean is over the rows of the log, not the level W of the process: the wind is W + w(t), with
    w a Gauss-Markov process. The data determine its mean over the flight far better than W. With G
    = Cov(mean of w, data), the best prediction adds G C⁻¹(y − Xβ) to the estimate of W (Goldberger
    1962; Robinson, "That BLUP is a good thing", Statistical Science 6, 1991).

    Parameters: noise, which includes the process; problem; kernel (n,), see `kernel_means`;
    deviation, the standard deviation of the process [m/s]; first.
    """
    winds = slice(first, first + 2)
    crossed = deviation**2 * kernel[:, None] * problem.regressors[:, winds]  # Gᵀ
    weighed = noise.weigh(crossed)
    unknown = deviation**2 * float(np.mean(kernel)) * np.eye(2) - crossed.T @ weighed
    return MeanWind(winds, problem, weighed, _at_least(unknown, _COARSE * deviation**2))


def _at_least(matrix: Array, floor: float) -> Array:
    """A symmetric matrix with eigenvalues raised to a floor."""
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    return np.asarray((vectors * np.maximum(values, floor)) @ vectors.T)
