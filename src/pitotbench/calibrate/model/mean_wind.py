"""The wind that a drifting log reports: its mean over the rows, not the level around which it would drift for ever.

Of a wind W + w(t) with w a Gauss-Markov process, the data show the mean over the flight far better than W. With
G = Cov(mean of w, data) the best prediction adds G C⁻¹(y − Xβ) to the estimate of W (Goldberger 1962; Robinson,
"That BLUP is a good thing", Statistical Science 6, 1991).
"""

from dataclasses import dataclass

import numpy as np

from pitotbench.calibrate.model.wind_jump import middles
from pitotbench.calibrate.rows.blocks import Blocks
from pitotbench.estimate.joint_noise import Noise
from pitotbench.estimate.restricted_likelihood import Regression
from pitotbench.units import Array

_COARSE = (
    5e-5  # what taking blocks for points may be wrong by, in units of the process's variance: 0.6 cm/s at 1 m/s
)


def correlations(blocks: Blocks, correlation_time: float) -> Array:
    """Correlation of the process in each block with that in each other, (blocks, blocks) [-]."""
    middle = middles(blocks)
    return np.asarray(np.exp(-np.abs(middle[:, None] - middle[None, :]) / correlation_time))


def kernel_means(blocks: Blocks, correlation_time: float) -> Array:
    """Correlation of the process in each block with its mean over all rows, (blocks,) [-]."""
    return np.asarray(correlations(blocks, correlation_time) @ (blocks.count / blocks.count.sum()))


@dataclass(frozen=True, slots=True)
class MeanWind:
    """What takes an answer for the wind's level to one for its mean, under one noise: the wind's columns among the
    coefficients; the problem; G C⁻¹ as its transpose, (n, 2); and what the data leave unknown of the mean where the
    level is known, (2, 2) [(m/s)²]."""

    winds: slice
    problem: Regression
    weighed: Array
    unknown: Array

    def of(self, answer: tuple[Array, Array]) -> tuple[Array, Array]:
        """An answer (estimate (p,), covariance (p, p)) whose wind components are those of the mean wind."""
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

    `kernel`: see `kernel_means`; `deviation`: of the process [m/s]; `noise` includes the process.
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
