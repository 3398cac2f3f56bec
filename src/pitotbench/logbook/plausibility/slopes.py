"""The slope of one channel on another, with an error that allows for weather and gusts."""

import numpy as np

from pitotbench.units import Array

_BLOCK = 5.0  # s, over which values are averaged: longer than the probe, the gauge and the receiver lag
_LASTING = 4.0  # blocks for which weather and gusts last: as many times fewer blocks count for the error


def block_slope(time: Array, design: Array, values: Array) -> tuple[float, float]:
    """The coefficient of the second row of `design`, (m, n), in a least-squares fit to `values`, (n,), over means
    of blocks of time, and its standard error; infinite where the log is too short."""
    number = np.unique(np.floor(time / _BLOCK), return_inverse=True)[1]
    count = np.bincount(number)
    columns = np.stack([np.bincount(number, row) / count for row in design])
    answer = np.bincount(number, values) / count
    spare = len(count) - len(columns)
    if spare < 3:
        return 0.0, float("inf")
    scale = np.maximum(np.sqrt(np.mean(columns**2, axis=1)), 1e-12)
    matrix = (columns / scale[:, None]).T
    if np.linalg.matrix_rank(matrix) < len(scale):
        return 0.0, float("inf")
    solution = np.linalg.lstsq(matrix, answer, rcond=None)[0]
    variance = float(np.sum((answer - matrix @ solution) ** 2)) / spare
    covariance = _LASTING * variance * np.linalg.inv(matrix.T @ matrix)
    return float(solution[1] / scale[1]), float(np.sqrt(covariance[1, 1]) / scale[1])
