"""The wind that a drifting log reports: its mean over the rows, not the level around which it would drift for ever.

Of a wind W + w(t) with w a Gauss-Markov process, the data show the mean over the flight far better than W. With
G = Cov(mean of w, data) the best prediction adds G C⁻¹(y − Xβ) to the estimate of W (Goldberger 1962; Robinson,
"That BLUP is a good thing", Statistical Science 6, 1991).
"""

import numpy as np

from pitotbench.calibrate.blocks import Blocks
from pitotbench.estimate.markov_noise import MarkovNoise
from pitotbench.estimate.restricted_likelihood import Regression
from pitotbench.units import Array


def kernel_means(blocks: Blocks, correlation_time: float) -> Array:
    """Correlation of the process in each block with its mean over all rows, (blocks,) [-]."""
    middle = 0.5 * (
        blocks.intervals.edges[blocks.intervals.left] + blocks.intervals.edges[blocks.intervals.left + 1]
    )
    apart = np.abs(middle[:, None] - middle[None, :])
    return np.asarray(np.exp(-apart / correlation_time) @ (blocks.count / blocks.count.sum()))


def of_mean_wind(
    answer: tuple[Array, Array],
    noise: MarkovNoise,
    problem: Regression,
    kernel: Array,
    deviation: float,
    first: int,
) -> tuple[Array, Array]:
    """An answer (estimate (p,), covariance (p, p)) whose wind components, from column `first` on, are those of the
    mean wind.

    `kernel`: see `kernel_means`; `deviation`: of the process [m/s]; `noise` includes the process.
    """
    winds = slice(first, first + 2)
    crossed = deviation**2 * kernel[:, None] * problem.regressors[:, winds]  # Gᵀ
    weighed = noise.weigh(crossed)
    estimate, covariance = answer[0].copy(), answer[1]
    estimate[winds] += weighed.T @ (problem.response - problem.regressors @ answer[0])
    known = np.eye(len(estimate))
    known[winds] -= weighed.T @ problem.regressors
    covariance = known @ covariance @ known.T
    prior = deviation**2 * float(np.mean(kernel)) * np.eye(2)
    covariance[winds, winds] += prior - crossed.T @ weighed
    return estimate, 0.5 * (covariance + covariance.T)
