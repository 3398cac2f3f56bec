"""Noise at points in time: white noise plus first-order recursions, with an exact likelihood in O(n).

The counterpart of `markov_noise` for slow processes, whose change within a block does not matter. A process is
x_j = kept_j x_{j−1} + e_j, with the variance of e_j given point by point: an Ornstein-Uhlenbeck process, a random
walk, and a walk that begins anywhere (infinite variance, so a flat prior) are all of this form. Their precision is
tridiagonal (Rue and Held, Gaussian Markov Random Fields, 2005, ch. 2). Columns with unknown factors (an offset, a
trend) can be made part of the noise: they are eliminated by the matrix-inversion lemma.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg.lapack import dpbtrf, dpbtrs  # direct: called hundreds of times a fit on short arrays

from pitotbench.units import Array, Booleans, Seconds


@dataclass(frozen=True, slots=True)
class Recursion:
    """One process over n points: the share of the last value that is kept, (n,), 0 where it begins anew; the
    variance of what is added, (n,), infinite where it may begin anywhere; and how each output sees it, (o,)."""

    kept: Array
    innovation: Array
    loading: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class UnknownColumns:
    """Columns with unknown factors, (rows, u), and the precision of each factor's prior around zero, (u,); 0 where
    nothing is known before."""

    columns: Array
    precision: Array


def ornstein_uhlenbeck(time: Seconds, deviation: float, memory: float, loading: tuple[float, ...]) -> Recursion:
    """A stationary process of a standard deviation and a correlation time [s] at times (n,)."""
    kept = np.concatenate([[0.0], np.exp(-np.diff(time) / memory)])
    innovation = np.concatenate([[1.0], -np.expm1(-2.0 * np.diff(time) / memory)])
    return Recursion(kept, deviation**2 * innovation, loading)


def random_walk(time: Seconds, rate: float, first: Booleans, loading: tuple[float, ...]) -> Recursion:
    """A walk whose variance grows by rate² a second; it begins anywhere at each `first` point, (n,) of bool."""
    step = np.diff(time, prepend=time[0])
    return Recursion(np.where(first, 0.0, 1.0), np.where(first, np.inf, rate**2 * step), loading)


class PointNoise:
    """The factored covariance of white noise plus recursions at n points, seen by o outputs.

    Parameters: white variance, (o, n), infinite where an output has no datum; recursions; unknown columns or None.
    The data are those of the first output, then those of the next; without the missing ones.
    Raises numpy.linalg.LinAlgError where the covariance is not positive definite.
    """

    def __init__(self, white: Array, processes: Sequence[Recursion], unknown: UnknownColumns | None = None) -> None:
        present = np.isfinite(white)
        self._precision = np.where(present, 1.0 / white, 0.0)
        ends = np.cumsum([0, *present.sum(axis=1)])
        self._rows = [slice(first, last) for first, last in pairwise(ends)]  # of the data, output by output
        self._places = [slice(None) if own.all() else np.flatnonzero(own) for own in present]
        self._loading = np.array([process.loading for process in processes])  # (m, o)
        self._seen = [np.flatnonzero(own) for own in self._loading.T]  # by each output
        self._log_determinant = float(np.sum(np.log(white[present])))
        self._factor = self._posterior_precision(processes)
        self._unknown = unknown
        self._weighed_columns: Array | None = None

    def _posterior_precision(self, processes: Sequence[Recursion]) -> Array:
        """Banded Cholesky factor of the states' precision given the data; states interleaved by point."""
        m, n = len(processes), self._precision.shape[1]
        bands = np.zeros((m + 1, m * n))
        for place, process in enumerate(processes):
            weight = 1.0 / process.innovation
            diagonal = weight.copy()
            diagonal[:-1] += process.kept[1:] ** 2 * weight[1:]
            bands[0, place::m] = diagonal
            bands[m, place : m * (n - 1) : m] = -process.kept[1:] * weight[1:]
            self._log_determinant += float(np.sum(np.log(process.innovation[np.isfinite(process.innovation)])))
            for other in range(place + 1):
                known = (self._loading[place] * self._loading[other]) @ self._precision
                bands[place - other, other::m] += known
        factor, failed = dpbtrf(bands, lower=1, overwrite_ab=1)
        if failed:
            raise np.linalg.LinAlgError("the covariance of the noise is not positive definite")
        self._log_determinant += 2.0 * float(np.sum(np.log(factor[0])))
        return np.asarray(factor)

    def _eliminate(self, unknown: UnknownColumns, weighed: Array) -> None:
        inner = unknown.columns.T @ weighed + np.diag(unknown.precision)
        scale = np.sqrt(np.diag(inner))
        root = np.linalg.cholesky(inner / np.outer(scale, scale))
        known = unknown.precision[unknown.precision > 0.0]
        self._weighed_columns = weighed
        self._inner_inverse = np.linalg.inv(root @ root.T) / np.outer(scale, scale)
        self._log_determinant += 2.0 * float(np.sum(np.log(scale * np.diag(root)))) - float(np.sum(np.log(known)))

    @property
    def log_determinant(self) -> float:
        """ln|C|, less what infinite variances add to it."""
        if self._unknown is not None and self._weighed_columns is None:
            self._eliminate(self._unknown, self._solve(self._unknown.columns))
        return self._log_determinant

    def weigh(self, data: Array) -> Array:
        """C⁻¹ times data of shape (rows, k)."""
        if self._unknown is None:
            return self._solve(data)
        if self._weighed_columns is None:  # columns and first data in one go: half the calls
            count = self._unknown.columns.shape[1]
            both = self._solve(np.concatenate([self._unknown.columns, data], axis=1))
            self._eliminate(self._unknown, both[:, :count])
            weighed = both[:, count:]
        else:
            weighed = self._solve(data)
        assert self._weighed_columns is not None
        return np.asarray(
            weighed - self._weighed_columns @ (self._inner_inverse @ (self._weighed_columns.T @ data))
        )

    def _solve(self, data: Array) -> Array:
        """The inverse covariance of the white noise and the processes alone, times data."""
        m, points, columns = len(self._loading), self._precision.shape[1], data.shape[1]
        scaled = np.zeros((len(self._precision), columns, points))  # transposed, as the banded solver wants it
        right = np.zeros((columns, m * points))
        for output, (part, rows) in enumerate(zip(scaled, self._rows, strict=True)):
            part[:, self._places[output]] = data[rows].T
            part *= self._precision[output]
            for place in self._seen[output]:
                right[:, place::m] += self._loading[place, output] * part
        state = dpbtrs(self._factor, right.T, lower=1, overwrite_b=1)[0].T
        weighed = np.empty_like(data)
        for output, (part, rows) in enumerate(zip(scaled, self._rows, strict=True)):
            for place in self._seen[output]:
                part -= (self._loading[place, output] * self._precision[output]) * state[:, place::m]
            weighed[rows] = part[:, self._places[output]].T
        return weighed
