"""Noise that has a memory: white noise plus first-order Gauss-Markov processes, with an exact likelihood.

The covariance of N samples is C = diag(r) + Σ_j σ_j² (c_j c_jᵀ ∘ exp(−|t−t'|/τ_j)). Its inverse is never formed:
a Gauss-Markov process has a tridiagonal precision (Rue and Held, Gaussian Markov Random Fields, 2005, ch. 2),
so products with C⁻¹ and log|C| cost O(N) through one banded Cholesky factor and the matrix-inversion lemma.
Times may be irregular, gaps need no special care, and the white variance may vary from sample to sample.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpbtrf, dpbtrs  # direct: called hundreds of times a fit on short logs

from pitotbench.units import Array, Seconds


@dataclass(frozen=True, slots=True)
class MarkovProcess:
    """One process: standard deviation [unit of the data], correlation time [s] (one a sample, (n,)), and its
    loading on each sample, (n,) (ones for noise that adds directly, a direction cosine for a wind component).
    """

    deviation: float
    correlation_time: Seconds
    loading: Array


class MarkovNoise:
    """The factored covariance of white noise plus Markov processes at given times.

    Parameters: time [s], shape (n,), increasing; white variance, (n,) [unit²], positive; processes.
    Raises numpy.linalg.LinAlgError where the covariance is not positive definite (never for valid input).
    """

    def __init__(self, time: Seconds, white: Array, processes: Sequence[MarkovProcess]) -> None:
        self.white = white
        self.width = len(processes)
        self.log_determinant = float(np.sum(np.log(white)))
        if self.width:
            self._load = np.stack([p.deviation * p.loading for p in processes], axis=1)
            self._factor = self._posterior_precision(np.diff(time), processes)

    def _posterior_precision(self, step: Seconds, processes: Sequence[MarkovProcess]) -> Array:
        """Banded Cholesky factor of the states' precision given the data; states interleaved by time."""
        n, m = len(self.white), self.width
        bands = np.zeros((m + 1, n * m))
        for j, process in enumerate(processes):
            decay = np.exp(-step / process.correlation_time[1:])
            innovation = -np.expm1(-2.0 * step / process.correlation_time[1:])
            diagonal = np.ones(n)
            diagonal[1:] = 1.0 / innovation
            diagonal[:-1] += decay**2 / innovation
            bands[0, j::m] += diagonal
            bands[m, j : (n - 1) * m : m] -= decay / innovation
            self.log_determinant += float(np.sum(np.log(innovation)))
        for j in range(m):
            for i in range(j + 1):
                bands[j - i, i::m] += self._load[:, i] * self._load[:, j] / self.white
        factor, failed = dpbtrf(bands, lower=1)
        if failed:
            raise np.linalg.LinAlgError("the covariance of the noise is not positive definite")
        self.log_determinant += 2.0 * float(np.sum(np.log(factor[0])))
        return np.asarray(factor)

    def weigh(self, data: Array) -> Array:
        """C⁻¹ times data of shape (n, k)."""
        scaled = data / self.white[:, None]
        if not self.width:
            return scaled
        n, m = self._load.shape
        right = (self._load[:, :, None] * scaled[:, None, :]).reshape(n * m, -1)
        state, _ = dpbtrs(self._factor, right, lower=1)
        explained = np.sum(self._load[:, :, None] * state.reshape(n, m, -1), axis=1)
        return np.asarray(scaled - explained / self.white[:, None])
