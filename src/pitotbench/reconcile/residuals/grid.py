"""The instants at which residuals are taken, and the one filter for all that is measured."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from pitotbench.reconcile.residuals.track import HALF_WINDOW, SLOW_GPS, Track
from pitotbench.units import Array

Indices = NDArray[np.intp]

STEP = 0.5  # s between instants; the period of the fixes where that is longer
MARGIN = 1.0  # s left out at both ends of a stretch


@dataclass(frozen=True, slots=True)
class Grid:
    """Center rows of the instants, (n,); `first` is true at the first of every stretch; `step` [s] between them;
    `taps` are the filter's weights over the rows around a center, symmetric, their sum one."""

    rows: Indices
    first: NDArray[np.bool_]
    step: float
    taps: Array
    filters_gps: bool

    def __len__(self) -> int:
        return len(self.rows)

    def smooth(self, values: Array, gps: bool = False) -> Array:
        """A channel at the instants, filtered; fixes of a slow GPS as they are."""
        return self._at(self.rows, values, gps)

    def smooth_answer(self, values: Array, rows: Indices) -> Array:
        """Columns given at some rows, (m, k), seen at the instants through the same filter, (n, k)."""
        half = len(self.taps) // 2
        wanted = np.clip(self.rows[:, None] + np.arange(-half, half + 1), rows[0], rows[-1])
        left = np.clip(np.searchsorted(rows, wanted, side="right") - 1, 0, len(rows) - 2)
        share = (wanted - rows[left]) / (rows[left + 1] - rows[left])
        near = np.arange(len(wanted))[:, None] * np.ones_like(left)
        weights = coo_array(
            (
                np.concatenate([(self.taps * (1.0 - share)).ravel(), (self.taps * share).ravel()]),
                (np.tile(near.ravel(), 2), np.concatenate([left.ravel(), left.ravel() + 1])),
            ),
            shape=(len(wanted), len(rows)),
        )
        return np.asarray(weights.tocsr() @ values)

    def _at(self, rows: Indices, values: Array, gps: bool) -> Array:
        if gps and not self.filters_gps:
            return values[rows]
        half = len(self.taps) // 2
        around = np.clip(rows[:, None] + np.arange(-half, half + 1), 0, len(values) - 1)
        return np.asarray(values[around] @ self.taps)

    def mean_between(self, values: Array, gps: bool = False) -> Array:
        """Mean of a channel from the instant before to each instant, by the trapezoidal rule on all rows between,
        seen through the same filter as velocities; 0 at the first of every stretch."""
        total = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]))])
        seen = self.smooth(total, gps)
        rows = np.diff(self.rows, prepend=self.rows[0])
        mean = np.diff(seen, prepend=seen[0]) / np.maximum(rows, 1)
        return np.where(self.first, 0.0, mean)

    def rate(self, seen: Array, track: Track) -> Array:
        """Difference quotient of values at the instants, from the one before; 0 at the first of every stretch."""
        seconds = np.maximum(np.diff(self.rows, prepend=self.rows[0]), 1) * track.row_period
        return np.where(self.first, 0.0, np.diff(seen, prepend=seen[0]) / seconds)


def grid_of(track: Track) -> Grid:
    """The instants of a track."""
    slow = track.fix_period >= SLOW_GPS
    margin = int(np.ceil(MARGIN / track.row_period))
    half = max(1, round(HALF_WINDOW / track.row_period))
    rows, first = [], []
    for begin, end in zip(track.start[:-1], track.start[1:], strict=True):
        if slow:
            fixes = track.fix[(track.fix >= begin + margin) & (track.fix < end - margin)]
            every = max(1, int(np.ceil(STEP / track.fix_period - 0.01)))
            chosen = fixes[::every]
        else:
            chosen = np.arange(begin + margin, end - margin, max(1, round(STEP / track.row_period)))
        rows.append(chosen)
        first.append(np.arange(len(chosen)) == 0)
    step = max(STEP, track.fix_period) if slow else max(1, round(STEP / track.row_period)) * track.row_period
    taps = np.ones(2 * half + 1)
    taps[[0, -1]] = 0.5
    return Grid(np.concatenate(rows), np.concatenate(first), step, taps / taps.sum(), not slow)
