"""The instants at which residuals are taken, and the one filter that all measured channels pass."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from pitotbench.reconcile.residuals.track import HALF_WINDOW, SLOW_GPS, Track
from pitotbench.units import Array

Indices = NDArray[np.intp]

STEP = 0.5  # s between instants; the period of the GPS fixes where it is longer
MARGIN = 1.0  # s at both ends of a stretch that are not used: the filter and the smoothing end there


@dataclass(frozen=True, slots=True)
class Grid:
    """The instants of a track.

    `rows` are the rows at the centers, (n,); `first` is true at the first instant of every stretch; `step` [s] is
    the time between instants. `taps` are the weights of the filter over the rows around a center: symmetric, with
    the sum 1. A slow GPS is not filtered (`filters_gps` is False).
    """

    rows: Indices
    first: NDArray[np.bool_]
    step: float
    taps: Array
    filters_gps: bool
    _kept: list[tuple[Indices, csr_array]] = field(default_factory=list, compare=False, repr=False)

    def __len__(self) -> int:
        return len(self.rows)

    def smooth(self, values: Array, gps: bool = False) -> Array:
        """Return a channel at the instants, filtered; the fixes of a slow GPS are taken as they are."""
        return self._at(self.rows, values, gps)

    def smooth_answer(self, values: Array, rows: Indices) -> Array:
        """Return columns given at some rows, (m, k), at the instants through the same filter, (n, k)."""
        return np.asarray(self._answer_weights(rows) @ values)

    def _answer_weights(self, rows: Indices) -> csr_array:
        """The filter as a matrix from values at some rows to the instants, (n, m); the last one is kept."""
        if not self._kept or self._kept[0][0] is not rows:
            self._kept[:] = [(rows, self._new_weights(rows))]
        return self._kept[0][1]

    def _new_weights(self, rows: Indices) -> csr_array:
        half = len(self.taps) // 2
        wanted = np.clip(self.rows[:, None] + np.arange(-half, half + 1), rows[0], rows[-1])
        before = np.clip(np.searchsorted(rows, wanted, side="right") - 1, 0, len(rows) - 2)
        share = (wanted - rows[before]) / (rows[before + 1] - rows[before])
        instant = np.arange(len(wanted))[:, None] * np.ones_like(before)
        weights = coo_array(
            (
                np.concatenate([(self.taps * (1.0 - share)).ravel(), (self.taps * share).ravel()]),
                (np.tile(instant.ravel(), 2), np.concatenate([before.ravel(), before.ravel() + 1])),
            ),
            shape=(len(wanted), len(rows)),
        )
        return weights.tocsr()

    def _at(self, rows: Indices, values: Array, gps: bool) -> Array:
        if gps and not self.filters_gps:
            return values[rows]
        half = len(self.taps) // 2
        around = np.clip(rows[:, None] + np.arange(-half, half + 1), 0, len(values) - 1)
        return np.asarray(values[around] @ self.taps)

    def mean_between(self, values: Array, gps: bool = False) -> Array:
        """Return the mean of a channel from the previous instant to each instant; 0 at the first of every stretch.

        The integral by the trapezoidal rule passes the same filter as velocities do.
        """
        total = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]))])
        integral = self.smooth(total, gps)
        rows = np.diff(self.rows, prepend=self.rows[0])
        mean = np.diff(integral, prepend=integral[0]) / np.maximum(rows, 1)
        return np.where(self.first, 0.0, mean)

    def rate(self, values: Array, track: Track) -> Array:
        """Return the change a second since the previous instant of values at the instants, (n,).

        It is 0 at the first instant of every stretch.
        """
        seconds = np.maximum(np.diff(self.rows, prepend=self.rows[0]), 1) * track.row_period
        return np.where(self.first, 0.0, np.diff(values, prepend=values[0]) / seconds)


def grid_of(track: Track) -> Grid:
    """Return the instants of a track."""
    slow = track.fix_period >= SLOW_GPS
    margin = int(np.ceil(MARGIN / track.row_period))
    half = max(1, round(HALF_WINDOW / track.row_period))
    every = max(1, int(np.ceil(STEP / track.fix_period - 0.01))) if slow else max(1, round(STEP / track.row_period))
    rows, first = [], []
    for begin, end in zip(track.start[:-1], track.start[1:], strict=True):
        if slow:
            fixes = track.fix[(track.fix >= begin + margin) & (track.fix < end - margin)]
            chosen = fixes[::every]
        else:
            chosen = np.arange(begin + margin, end - margin, every)
        rows.append(chosen)
        first.append(np.arange(len(chosen)) == 0)
    step = every * (track.fix_period if slow else track.row_period)
    taps = np.ones(2 * half + 1)
    taps[[0, -1]] = 0.5
    return Grid(np.concatenate(rows), np.concatenate(first), step, taps / taps.sum(), not slow)
