"""Averages over short blocks: the slow truth stays, the fast sensor noise averages out, the sums get short."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibrate.rows.observations import Observations
from pitotbench.estimate.markov_noise import Intervals
from pitotbench.units import Array

_BLOCK = 1.0  # s: short against a gust (8 s at 65 m/s), long against the sensors' sampling
_SHORT, _SHORT_BLOCK = 120.0, 0.5  # s: below so much data, so long a block
_LONG, _LONG_BLOCK = 480.0, 2.0  # s: above so much data, so long a block


@dataclass(frozen=True, slots=True)
class Blocks:
    """Which block each row is in, (rows,), the rows a block, (n,), and where the blocks lie in time."""

    index: NDArray[np.intp]
    count: Array
    intervals: Intervals
    length: float

    def mean(self, data: Array) -> Array:
        """Block means of (rows,) or (rows, k) data."""
        if data.ndim == 1:
            return np.asarray(np.bincount(self.index, data, len(self.count)) / self.count)
        return np.stack([self.mean(column) for column in data.T], axis=1)

    def at_edges(self, block_values: Array) -> Array:
        """Block values (n,) carried to the intervals' edges, (s,)."""
        edges = np.empty(len(self.intervals.edges))
        edges[self.intervals.left + 1] = block_values
        edges[self.intervals.left] = block_values
        return edges


def block_length(obs: Observations) -> float:
    """One second, half below two minutes of data, two above eight."""
    duration = len(obs) * float(np.median(np.diff(obs.time)))
    return _SHORT_BLOCK if duration < _SHORT else _LONG_BLOCK if duration > _LONG else _BLOCK


def divide(obs: Observations, length: float) -> Blocks:
    """Blocks of a length [s], never across a pause."""
    offset = obs.time - obs.time[0]
    cell = np.floor((offset + 0.5 * length) / length).astype(np.intp)
    cells = int(cell[-1]) + 2
    key, index, count = np.unique(cell + obs.stretch * cells, return_inverse=True, return_counts=True)
    return Blocks(index, count.astype(np.float64), _intervals(key, cells, length), length)


def _intervals(key: NDArray[np.intp], cells: int, length: float) -> Intervals:
    """Edges of the blocks: neighbors share one, an empty cell or a new stretch starts a new one."""
    cell = key % cells
    joined = np.concatenate([[False], (np.diff(key) == 1)])
    left = np.cumsum(np.where(joined, 1, 2)) - 2
    edges = np.empty(left[-1] + 2)
    edges[left + 1] = (cell + 0.5) * length
    edges[left] = (cell - 0.5) * length
    return Intervals(edges, left)
