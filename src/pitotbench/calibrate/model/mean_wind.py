"""The wind reported for a drifting wind: the mean over the rows of the log, not the level W of the process.

The wind is W + w(t), with w a Gauss-Markov process. The data determine its mean over the flight far better than W.
With G = Cov(mean of w, data), the best prediction adds G C⁻¹(y − Xβ) to the estimate of W (Goldberger 1962;
Robinson, "That BLUP is a good thing", Statistical Science 6, 1991).
"""

from dataclasses import dataclass

import numpy as np

from pitotbench.calibrate.rows.blocks import Blocks
from pitotbench.estimate.joint_noise import Noise
from pitotbench.estimate.restricted_likelihood import Regression
from pitotbench.units import Array

# Error of treating blocks as points, as a share of the process's variance: 0.7 cm/s at 1 m/s.
_COARSE = 5e-5


def kernel_means(blocks: Blocks, correlation_time: float) -> Array:
    """Correlation of the process in each block with its mean over all rows, (blocks,) [-].

    `correlation_time` [s] is that of the process.
    """
    middle = 0.5 * (
        blocks.intervals.edges[blocks.intervals.left] + blocks.intervals.edges[blocks.intervals.left + 1]
    )
    apart = np.abs(middle[:, None] - middle[None, :])
    return np.asarray(np.exp(-apart / correlation_time) @ (blocks.count / blocks.count.sum()))


@dataclass(frozen=True, slots=True)
class MeanWind:
    """The map from an answer for the wind's level to one for its mean, under one noise.

    `winds` are the wind's columns among the coefficients. `weighed` (n, 2) is the transpose of G C⁻¹. `unknown`
    (2, 2) [(m/s)²] is the covariance of the mean, given the data and the level.
    """

    winds: slice
    problem: Regression
    weighed: Array
    unknown: Array

    def of(self, answer: tuple[Array, Array]) -> tuple[Array, Array]:
        """Return the answer (estimate (p,), covariance (p, p)) with the mean wind in place of the wind's level."""
        response, regressors = self.problem.response, self.problem.regressors
        estimate, covariance = answer[0].copy(), answer[1]
        estimate[self.winds] += self.weighed.T @ (response - regressors @ answer[0])
        known = np.eye(len(estimate))
        known[self.winds] -= self.weighed.T @ regressors
        covariance = known @ covariance @ known.T
        covariance[self.winds, self.winds] += self.unknown
        return estimate, 0.5 * (covariance + covariance.T)


def mean_wind(noise: Noise, problem: Regression, kernel: Array, deviation: float, first: int) -> MeanWind:
    """The mean wind of a problem whose wind columns begin at `first`.

    Parameters: noise, which includes the process; problem; kernel (n,), see `kernel_means`; deviation, the standard
    deviation of the process [m/s]; first.
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
