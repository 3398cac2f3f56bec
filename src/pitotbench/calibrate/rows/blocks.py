"""Means over short blocks: they keep slow signals, average out fast sensor noise and shorten the sums."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibrate.rows.observations import Observations
from pitotbench.estimate.markov_noise import Intervals
from pitotbench.units import Array

_BLOCK = 1.0  # s: short against a gust (8 s at 65 m/s), long against the sensors' sampling
_SHORT, _SHORT_BLOCK = 120.0, 0.5  # s: blocks of a log with less data
_LONG, _LONG_BLOCK = 480.0, 2.0  # s: blocks of a log with more data


@dataclass(frozen=True, slots=True)
class Blocks:
    """The block of each row, (rows,), the number of rows per block, (n,), and the blocks' intervals in time.

    `length` is that of a block [s].
    """

    index: NDArray[np.intp]
    count: Array
    intervals: Intervals
    length: float

    def mean(self, data: Array) -> Array:
        """Block means, (n,) or (n, k), of (rows,) or (rows, k) data."""
        if data.ndim == 1:
            return np.asarray(np.bincount(self.index, data, len(self.count)) / self.count)
        return np.stack([self.mean(column) for column in data.T], axis=1)

    def at_edges(self, block_values: Array) -> Array:
        """Assign block values (n,) to the intervals' edges, (s,); a shared edge has that of the later block."""
        edges = np.empty(len(self.intervals.edges))
        edges[self.intervals.left + 1] = block_values
        edges[self.intervals.left] = block_values
        return edges


def block_length(obs: Observations) -> float:
    """Length of a block [s]: 1, but 0.5 for less than two minutes of data and 2 for more than eight."""
    duration = len(obs) * float(np.median(np.diff(obs.time)))
    return _SHORT_BLOCK if duration < _SHORT else _LONG_BLOCK if duration > _LONG else _BLOCK


def divide(obs: Observations, length: float) -> Blocks:
    """Divide the rows into blocks of a length [s]. No block spans a pause."""
    offset = obs.time - obs.time[0]
    cell = np.floor((offset + 0.5 * length) / length).astype(np.intp)
    cells = int(cell[-1]) + 2
    key, index, count = np.unique(cell + obs.stretch * cells, return_inverse=True, return_counts=True)
    return Blocks(index, count.astype(np.float64), _intervals(key, cells, length), length)


def _intervals(key: NDArray[np.intp], cells: int, length: float) -> Intervals:
    """Edges of the blocks. Neighbors share one; after an empty cell, or in a new stretch, there is a new one."""
    cell = key % cells
    joined = np.concatenate([[False], (np.diff(key) == 1)])
    left = np.cumsum(np.where(joined, 1, 2)) - 2
    edges = np.empty(left[-1] + 2)
    edges[left + 1] = (cell + 0.5) * length
    edges[left] = (cell - 0.5) * length
    return Intervals(edges, left)
