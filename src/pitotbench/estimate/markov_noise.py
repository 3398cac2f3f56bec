"""Correlated noise: white noise plus first-order Gauss-Markov processes, with an exact likelihood in linear time.

The data are means over short intervals. The states of a process are its values at the edges of the intervals. Given
these, the mean over an interval is known up to an independent remainder, the integral of an Ornstein-Uhlenbeck
bridge. A Gauss-Markov process has a tridiagonal precision (Rue and Held, Gaussian Markov Random Fields, 2005,
ch. 2). One banded Cholesky factor and the matrix-inversion lemma therefore give products with C⁻¹ and log|C| in
O(N); C itself is never formed.

Intervals may have gaps between them, and the white variance may differ from interval to interval. Several outputs
an interval (such as the velocity along and across the path) may share the processes with different loadings; their
data follow each other, output by output.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpbtrf, dpbtrs  # direct: called hundreds of times a fit on short arrays

from pitotbench.units import Array, Seconds

_SMALL = 1e-2  # interval over correlation time below which the bridge's leading term is exact enough
_SAME = 1e-12  # step over correlation time below which values at two edges are the same to rounding
_SINGULAR = "the covariance of the noise is not positive definite"


@dataclass(frozen=True, slots=True)
class Intervals:
    """The intervals of the data.

    `edges` are times [s], (s,), increasing. `left` is the index of the edge that starts each interval, (n,),
    increasing; the next edge ends it.
    """

    edges: Seconds
    left: NDArray[np.intp]

    @property
    def length(self) -> Seconds:
        """The length of each interval [s], (n,)."""
        return self.edges[self.left + 1] - self.edges[self.left]


@dataclass(frozen=True, slots=True)
class MarkovProcess:
    """A process with c independent components of equal statistics.

    `deviation` is the standard deviation [unit of the data], a number, or (b,) for a stack of noises.
    `correlation_time` [s], (s,) or (b, s), holds from each edge to the next; its last entry is not used. `loading`
    is the effect of each component on each interval, (n, c), or (o, n, c) for o outputs: a column of ones for noise
    that adds directly, direction cosines for the components of a wind. The loadings of two outputs must be at right
    angles in every interval, so that the remainders within an interval are independent.
    """

    deviation: float | Array
    correlation_time: Seconds
    loading: Array


class MarkovNoise:
    """The factored covariance of white noise plus Markov processes over intervals, or a stack of b of them.

    Parameters: intervals; white, the variance of the white noise [unit²], positive, (n,), or (o, n) for o outputs,
    or (b, o, n) for a stack; processes. A stack costs less than its noises one by one: most of the time of a short
    log goes to the calls on its short arrays. Its numbers are the same bit for bit.
    Raises numpy.linalg.LinAlgError where a covariance is not positive definite. For valid input this happens only
    where a correlation time is so long that two edges have the same value to rounding.
    """

    def __init__(self, intervals: Intervals, white: Array, processes: Sequence[MarkovProcess]) -> None:
        # Two edges without data between them get an empty interval, without load or weight. Every array is then
        # regular, and slices replace indices, which would take longer than the arithmetic.
        _require_an_end(np.diff(intervals.edges), processes)
        self._rows = intervals.left
        self._stacked = white.ndim == 3
        white = white if self._stacked else np.atleast_2d(white)[None]
        self._variance = np.ones((*white.shape[:2], len(intervals.edges) - 1))
        self._variance[:, :, self._rows] = white
        self._width = sum(process.loading.shape[-1] for process in processes)
        self._states = len(intervals.edges) * self._width
        self._loads = self._interval_means(intervals, processes)
        self._log_determinant: Array = np.log(self._variance).reshape(len(white), -1).sum(axis=1)
        self._factors: list[Array] = []
        if processes:
            self._factors = self._posterior_precision(np.diff(intervals.edges), processes)

    @property
    def log_determinant(self) -> float:
        """ln|C|, of one noise."""
        return float(self._log_determinant[0])

    @property
    def log_determinants(self) -> Array:
        """ln|C| of every noise of a stack, (b,)."""
        return self._log_determinant

    def _interval_means(self, intervals: Intervals, processes: Sequence[MarkovProcess]) -> list[list[Array]]:
        """Return the loads of the interval means on the components at their two edges, output by output, (b, n).

        The variance of the remainders (the bridges) is added to the white variance. With a = Δ/τ,
        E[mean | edges] = tanh(a/2)/a · (sum of the edges); the remainder follows from the total variance.
        """
        outputs = range(self._variance.shape[1])
        loads: list[list[Array]] = [[] for _ in outputs]
        for process in processes:
            deviation = np.asarray(process.deviation)[..., None]
            a = np.atleast_2d(intervals.length / process.correlation_time[..., intervals.left])
            share = np.tanh(0.5 * a) / a
            decay = np.exp(-a)
            rest = 2.0 * (a - 1.0 + decay) / a**2 - 2.0 * share**2 * (1.0 + decay)
            # For short intervals the formula subtracts nearly equal numbers; its leading term is a/6.
            rest = np.where(a < _SMALL, a / 6.0, rest)
            for output, loading in zip(outputs, _by_output(process.loading), strict=True):
                self._variance[:, output, self._rows] += deviation**2 * np.sum(loading**2, axis=1) * rest
                for component in loading.T:
                    load = np.zeros((len(self._variance), self._variance.shape[2]))
                    load[:, self._rows] = deviation * share * component
                    loads[output].append(load)
        return [load + load for load in loads]

    def _at(self, place: int) -> slice:
        """Return the states that load number `place` of each interval multiplies: left edges, then right ones."""
        return slice(place, place + self._states - self._width, self._width)

    def _posterior_precision(self, step: Seconds, processes: Sequence[MarkovProcess]) -> list[Array]:
        """Return the banded Cholesky factors of the states' precision given the data; states ordered by edge."""
        m = self._width
        bands = np.zeros((len(self._variance), 2 * m, self._states))
        first = 0
        for process in processes:
            # A step has the correlation time of the edge that begins it, as its interval has.
            time = np.atleast_2d(process.correlation_time)[:, :-1]
            decay = np.exp(-step / time)
            innovation = -np.expm1(-2.0 * step / time)
            diagonal = np.ones((len(time), len(step) + 1))
            diagonal[:, 1:] = 1.0 / innovation
            diagonal[:, :-1] += decay**2 / innovation
            count = process.loading.shape[-1]
            for j in range(first, first + count):
                bands[:, 0, j::m] = diagonal
                bands[:, m, j : self._states - m : m] = -decay / innovation
            self._log_determinant += count * np.sum(np.log(innovation), axis=1)
            first += count
        self._add_data(bands)
        factors = []
        for place, band in enumerate(bands):
            factor, failed = dpbtrf(band, lower=1, overwrite_ab=1)
            if failed:
                raise np.linalg.LinAlgError(_SINGULAR)
            self._log_determinant[place] += 2.0 * float(np.sum(np.log(factor[0])))
            factors.append(factor)
        return factors

    def _add_data(self, bands: Array) -> None:
        """Add the information of the data on the states: products of the loads over the white variance."""
        for output, loads in enumerate(self._loads):
            for p, load in enumerate(loads):
                weighted = load / self._variance[:, output]
                for q in range(p + 1):
                    bands[:, p - q, self._at(q)] += weighted * loads[q]

    def weigh(self, data: Array) -> Array:
        """Return C⁻¹ times data of shape (n, k), or (o n, k) for o outputs; (b, n, k) of a stack."""
        (stack, outputs, cells), columns = self._variance.shape, data.shape[1]
        scaled = np.zeros((stack, outputs, columns, cells))  # transposed: as the banded solver wants it
        scaled[..., self._rows] = np.swapaxes(data.reshape(outputs, -1, columns), 1, 2)
        scaled /= self._variance[:, :, None, :]
        if self._factors:
            self._take_off_explained(scaled)
        weighed = np.swapaxes(scaled[..., self._rows], 2, 3).reshape(stack, -1, columns)
        return weighed if self._stacked else np.asarray(weighed[0])

    def _take_off_explained(self, scaled: Array) -> None:
        """Turn data over white variance, (b, o, k, intervals), into C⁻¹ times data, in place."""
        right = np.zeros((len(scaled), scaled.shape[2], self._states))
        for output, loads in enumerate(self._loads):
            for p, load in enumerate(loads):
                right[:, :, self._at(p)] += load[:, None, :] * scaled[:, output]
        for factor, part in zip(self._factors, right, strict=True):
            part[...] = dpbtrs(factor, part.T, lower=1, overwrite_b=1)[0].T
        for output, loads in enumerate(self._loads):
            variance = self._variance[:, None, output]
            for p, load in enumerate(loads):
                scaled[:, output] -= load[:, None, :] * right[:, :, self._at(p)] / variance


def _require_an_end(step: Seconds, processes: Sequence[MarkovProcess]) -> None:
    """Raise LinAlgError where a process has the same value at two edges."""
    for process in processes:
        if not np.all(step > _SAME * process.correlation_time[..., :-1]):
            raise np.linalg.LinAlgError(_SINGULAR)


def _by_output(loading: Array) -> Array:
    """Return loadings (n, c) or (o, n, c) as (o, n, c)."""
    return loading if loading.ndim == 3 else loading[None]
