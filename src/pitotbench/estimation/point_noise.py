"""Noise at points in time: white noise plus first-order recursions, with exact likelihood in O(n).

The counterpart of `MarkovNoise` for slow processes, whose change within a block does not matter. A
process is x_j = kept_j x_{j−1} + e_j, with the variance of e_j given point by point: an
Ornstein-Uhlenbeck process, a random walk, and a walk that begins anywhere (infinite variance, so a
flat prior) are all of this form. Their precision is tridiagonal (Rue and Held, Gaussian Markov
Random Fields, 2005, ch. 2). Columns with unknown factors (an offset, a trend) can be made part of
the noise: they are eliminated by the matrix-inversion lemma.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg.lapack import dpbtrf, dpbtrs

from pitotbench.units import Array, Booleans, Seconds


@dataclass(frozen=True, slots=True)
class Recursion:
    """One process over n points.

    The share of the last value that is kept, (n,), 0 where it begins anew; the variance of what is
    added, (n,), infinite where it may begin anywhere; and how each output sees it, (o,).

    For a stack of b noises the first two are (b, n).
    """

    kept: Array
    innovation: Array
    loading: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class UnknownColumns:
    """Columns with unknown factors, (rows, u), and the precision of each factor's prior.

    The precisions, (u,), are around zero; 0 where nothing is known before.
    """

    columns: Array
    precision: Array


def ornstein_uhlenbeck(
    time: Seconds, deviation: float | Array, memory: float | Array, loading: tuple[float, ...]
) -> Recursion:
    """Return a stationary process of a deviation and a correlation time [s], or a stack of (b,).

    The process is at times (n,) [s].
    """
    deviation, memory = (np.asarray(each)[..., None] for each in (deviation, memory))
    step = np.diff(time)
    kept, added = np.exp(-step / memory), -np.expm1(-2.0 * step / memory)
    kept = np.concatenate([np.zeros_like(kept[..., :1]), kept], axis=-1)
    innovation = np.concatenate([np.ones_like(added[..., :1]), added], axis=-1)
    return Recursion(kept, deviation**2 * innovation, loading)


def random_walk(
    time: Seconds, rate: float | Array, first: Booleans, loading: tuple[float, ...]
) -> Recursion:
    """Return a walk from anywhere at each `first` point, (n,), its variance growing by rate² t."""
    step, rate = np.diff(time, prepend=time[0]), np.asarray(rate)[..., None]
    return Recursion(np.where(first, 0.0, 1.0), np.where(first, np.inf, rate**2 * step), loading)


class PointNoise:
    """The factored covariance, or a stack of b, of white noise and recursions at n points.

    Parameters: white variance of o outputs, (o, n), infinite where an output has no datum, or (b,
    o, n) for a stack; recursions; unknown columns or None. The noises of a stack have the same
    data, and their numbers are those of each alone, bit for bit. The data are those of the first
    output, then those of the next; without the missing ones. Raises numpy.linalg.LinAlgError where
    a covariance is not positive definite.
    """

    def __init__(
        self, white: Array, processes: Sequence[Recursion], unknown: UnknownColumns | None = None
    ) -> None:
        self._stacked = white.ndim == 3
        white = white if self._stacked else white[None]
        present = np.isfinite(white)
        self._precision = np.where(present, 1.0 / white, 0.0)
        ends = np.cumsum([0, *present[0].sum(axis=1)])
        self._rows = [
            slice(first, last) for first, last in pairwise(ends)
        ]  # of the data, output by output
        self._places = [slice(None) if own.all() else np.flatnonzero(own) for own in present[0]]
        self._loading = np.array([process.loading for process in processes])  # (m, o)
        self._seen = [np.flatnonzero(own) for own in self._loading.T]  # by each output
        self._log_determinant = _sums_of_logarithms(white, present[0])
        self._factors = self._posterior_precision(processes)
        self._unknown = unknown
        self._weighed_columns: Array | None = None

    def _posterior_precision(self, processes: Sequence[Recursion]) -> list[Array]:
        """Return banded Cholesky factors, by point, of the states' precision given the data."""
        m, (stack, _, n) = len(processes), self._precision.shape
        bands = np.zeros((stack, m + 1, m * n))
        for place, process in enumerate(processes):
            kept, innovation = np.atleast_2d(process.kept), np.atleast_2d(process.innovation)
            weight = 1.0 / innovation
            diagonal = weight.copy()
            diagonal[:, :-1] += kept[:, 1:] ** 2 * weight[:, 1:]
            bands[:, 0, place::m] = diagonal
            bands[:, m, place : m * (n - 1) : m] = -kept[:, 1:] * weight[:, 1:]
            self._log_determinant += _sums_of_logarithms(innovation, np.isfinite(innovation[0]))
            for other in range(place + 1):
                known = (self._loading[place] * self._loading[other]) @ self._precision
                bands[:, place - other, other::m] += known
        factors = []
        for place, band in enumerate(bands):
            factor, failed = dpbtrf(band, lower=1, overwrite_ab=1)
            if failed:
                raise np.linalg.LinAlgError("the covariance of the noise is not positive definite")
            self._log_determinant[place] += 2.0 * float(np.sum(np.log(factor[0])))
            factors.append(factor)
        return factors

    def _eliminate(self, unknown: UnknownColumns, weighed: Array) -> None:
        inner = unknown.columns.T @ weighed + np.diag(unknown.precision)
        scale = np.sqrt(np.diagonal(inner, axis1=1, axis2=2))
        scales = scale[:, :, None] * scale[:, None, :]
        root = np.linalg.cholesky(inner / scales)
        known = unknown.precision[unknown.precision > 0.0]
        self._weighed_columns = weighed
        self._inner_inverse = np.linalg.inv(root @ np.swapaxes(root, 1, 2)) / scales
        pivots = scale * np.diagonal(root, axis1=1, axis2=2)
        self._log_determinant += 2.0 * np.sum(np.log(pivots), axis=1) - float(np.sum(np.log(known)))

    @property
    def log_determinant(self) -> float:
        """ln|C| of one noise, less what infinite variances add to it."""
        return float(self.log_determinants[0])

    @property
    def log_determinants(self) -> Array:
        """ln|C| of every noise of a stack, (b,), less what infinite variances add to it."""
        if self._unknown is not None and self._weighed_columns is None:
            self._eliminate(self._unknown, self._solve(self._unknown.columns))
        return self._log_determinant

    def weigh(self, data: Array) -> Array:
        """C⁻¹ times data of shape (rows, k); (b, rows, k) of a stack."""
        weighed = self._weighed(data)
        return weighed if self._stacked else np.asarray(weighed[0])

    def _weighed(self, data: Array) -> Array:
        if self._unknown is None:
            return self._solve(data)
        if self._weighed_columns is None:  # columns and first data in one go: half the calls
            count = self._unknown.columns.shape[1]
            both = self._solve(np.concatenate([self._unknown.columns, data], axis=1))
            self._eliminate(self._unknown, both[:, :, :count])
            weighed = both[:, :, count:]
        else:
            weighed = self._solve(data)
        columns = self._weighed_columns
        assert columns is not None
        return np.asarray(
            weighed - columns @ (self._inner_inverse @ (np.swapaxes(columns, 1, 2) @ data))
        )

    def _solve(self, data: Array) -> Array:
        """Return the inverse covariances of white noise and processes times data, (b, rows, k)."""
        m, columns, (stack, outputs, points) = (
            len(self._loading),
            data.shape[1],
            self._precision.shape,
        )
        # transposed, as the banded solver wants it
        scaled = np.zeros((stack, outputs, columns, points))
        right = np.zeros((stack, columns, m * points))
        for output, rows in enumerate(self._rows):
            part, precision = scaled[:, output], self._precision[:, None, output]
            part[..., self._places[output]] = data[rows].T
            part *= precision
            for place in self._seen[output]:
                right[:, :, place::m] += self._loading[place, output] * part
        for factor, state in zip(self._factors, right, strict=True):
            state[...] = dpbtrs(factor, state.T, lower=1, overwrite_b=1)[0].T
        weighed = np.empty((stack, *data.shape))
        for output, rows in enumerate(self._rows):
            part, precision = scaled[:, output], self._precision[:, None, output]
            for place in self._seen[output]:
                part -= (self._loading[place, output] * precision) * right[:, :, place::m]
            weighed[:, rows] = np.swapaxes(part[..., self._places[output]], 1, 2)
        return weighed


def _sums_of_logarithms(values: Array, chosen: Booleans) -> Array:
    """The sum of the logarithms of the chosen ones of each of b arrays, (b,)."""
    # In row order: the sums are then those of each array alone, bit for bit.
    return np.asarray(
        np.log(np.compress(chosen.ravel(), values.reshape(len(values), -1), axis=1)).sum(axis=1)
    )
