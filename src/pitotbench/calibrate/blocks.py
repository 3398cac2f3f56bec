"""Averages over short blocks: the slow truth stays, the fast sensor noise averages out, the sums get short."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibrate.observations import Observations
from pitotbench.units import Array, Seconds

_BLOCK = 1.0  # s: short against a gust (8 s at 65 m/s), long against the sensors' sampling
_SHORT = 0.5  # s, for logs too short for 1 s


@dataclass(frozen=True, slots=True)
class Blocks:
    """Which block each row is in, rows a block, and the blocks' mean times [s]."""

    index: NDArray[np.intp]
    count: Array
    time: Seconds
    length: float

    def mean(self, data: Array) -> Array:
        """Block means of (n,) or (n, k) data."""
        if data.ndim == 1:
            return np.asarray(np.bincount(self.index, data, len(self.count)) / self.count)
        return np.stack([self.mean(column) for column in data.T], axis=1)


def divide(obs: Observations) -> Blocks:
    """Blocks of one second (half a second below two minutes of data), never across a gap."""
    duration = len(obs) * float(np.median(np.diff(obs.time)))
    length = _BLOCK if duration >= 120.0 else _SHORT
    offset = obs.time - obs.time[0]
    cell = np.floor((offset + 0.5 * length) / length)
    key = cell + obs.part * (cell[-1] + 2.0)
    _, index, count = np.unique(key, return_inverse=True, return_counts=True)
    weight = count.astype(np.float64)
    return Blocks(index, weight, np.bincount(index, obs.time) / weight, length)
