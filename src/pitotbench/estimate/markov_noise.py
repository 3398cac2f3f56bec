"""Noise that has a memory: white noise plus first-order Gauss-Markov processes, with an exact likelihood.

The data are means over short intervals. A process lives at the intervals' edges; given its values there, its mean
over an interval is known up to an independent rest (the integral of an Ornstein-Uhlenbeck bridge). A Gauss-Markov
process has a tridiagonal precision (Rue and Held, Gaussian Markov Random Fields, 2005, ch. 2), so products with C⁻¹
and log|C| cost O(N) through one banded Cholesky factor and the matrix-inversion lemma; C is never formed. Gaps
between intervals need no special care, and the white variance may vary from interval to interval.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpbtrf, dpbtrs  # direct: called hundreds of times a fit on short arrays

from pitotbench.units import Array, Seconds

_SMALL = 1e-2  # interval over correlation time below which the bridge's leading term is exact enough


@dataclass(frozen=True, slots=True)
class Intervals:
    """Where the data's intervals lie: edge times [s], (s,), increasing, and for each interval the index of the edge
    that starts it, (n,), increasing; the next edge ends it."""

    edges: Seconds
    left: NDArray[np.intp]

    @property
    def length(self) -> Seconds:
        """Length of each interval [s], (n,)."""
        return self.edges[self.left + 1] - self.edges[self.left]


@dataclass(frozen=True, slots=True)
class MarkovProcess:
    """One process: standard deviation [unit of the data], correlation time at the edges [s], (s,), and its loading
    on each interval, (n,) (ones for noise that adds directly, a direction cosine for a wind component)."""

    deviation: float
    correlation_time: Seconds
    loading: Array


class MarkovNoise:
    """The factored covariance of white noise plus Markov processes over intervals.

    Parameters: intervals; white variance, (n,) [unit²], positive; processes.
    Raises numpy.linalg.LinAlgError where the covariance is not positive definite (never for valid input).
    """

    def __init__(self, intervals: Intervals, white: Array, processes: Sequence[MarkovProcess]) -> None:
        self.log_determinant = 0.0
        self._variance = white.copy()
        self._left = intervals.left * len(processes)
        self._states = len(intervals.edges) * len(processes)
        self._loads = self._interval_means(intervals, processes)
        self.log_determinant += float(np.sum(np.log(self._variance)))
        if processes:
            self._factor = self._posterior_precision(np.diff(intervals.edges), processes)

    def _interval_means(self, intervals: Intervals, processes: Sequence[MarkovProcess]) -> list[Array]:
        """Loads of the interval means on the processes at their two edges; the bridges' rests join the white part.

        With a = Δ/τ: E[mean | edges] = tanh(a/2)/a · (sum of the edges), and the rest follows from the total.
        """
        loads = []
        for process in processes:
            a = intervals.length / process.correlation_time[intervals.left]
            share = np.tanh(0.5 * a) / a
            decay = np.exp(-a)
            rest = 2.0 * (a - 1.0 + decay) / a**2 - 2.0 * share**2 * (1.0 + decay)
            scale = process.deviation * process.loading
            self._variance += scale**2 * np.where(a < _SMALL, a / 6.0, rest)
            loads.append(scale * share)
        return loads + loads

    def _posterior_precision(self, step: Seconds, processes: Sequence[MarkovProcess]) -> Array:
        """Banded Cholesky factor of the states' precision given the data; states interleaved by edge."""
        m = len(processes)
        bands = np.zeros((2 * m, self._states))
        for j, process in enumerate(processes):
            decay = np.exp(-step / process.correlation_time[1:])
            innovation = -np.expm1(-2.0 * step / process.correlation_time[1:])
            diagonal = bands[0, j::m]
            diagonal += 1.0
            diagonal[1:] += 1.0 / innovation - 1.0
            diagonal[:-1] += decay**2 / innovation
            bands[m, j : self._states - m : m] -= decay / innovation
            self.log_determinant += float(np.sum(np.log(innovation)))
        for p, load in enumerate(self._loads):
            weighted = load / self._variance
            for q in range(p + 1):
                bands[p - q, self._left + q] += weighted * self._loads[q]
        factor, failed = dpbtrf(bands, lower=1)
        if failed:
            raise np.linalg.LinAlgError("the covariance of the noise is not positive definite")
        self.log_determinant += 2.0 * float(np.sum(np.log(factor[0])))
        return np.asarray(factor)

    def weigh(self, data: Array) -> Array:
        """C⁻¹ times data of shape (n, k)."""
        scaled = data.T / self._variance  # one row a column of the data: contiguous, as the banded solver wants it
        if not self._loads:
            return scaled.T
        right = np.zeros((data.shape[1], self._states))
        for p, load in enumerate(self._loads):
            right[:, self._left + p] += load * scaled
        state = dpbtrs(self._factor, right.T, lower=1, overwrite_b=1)[0].T
        explained = sum(load * state[:, self._left + p] for p, load in enumerate(self._loads))
        return np.asarray(scaled - explained / self._variance).T
