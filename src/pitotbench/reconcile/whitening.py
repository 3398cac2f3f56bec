"""Noise of the residual channels: an autoregression a channel, and the correlation of what it cannot foresee.

The order is high enough for gusts, vibration of the loops and differenced GPS noise alike; nothing is assumed about
their spectra. Learned on flights without an effect, or from the log itself where there are none (Lütkepohl, New
Introduction to Multiple Time Series Analysis, 2005, ch. 3, for the estimate; each channel on its own here).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz

from pitotbench.reconcile.grid import Grid
from pitotbench.units import Array

ORDER = 12
RIDGE = 1e-4  # share of white noise added, so that the equations stay well posed


@dataclass(frozen=True, slots=True)
class NoiseModel:
    """Prediction coefficients of each channel, (c, p), and the deviations of what they leave, (c,)."""

    names: tuple[str, ...]
    coefficients: Array
    deviations: Array

    def whiten(self, values: Array, grid: Grid, slack: Array) -> Array:
        """Innovations over their deviations, of (n, c) or (n, c, k); `slack` (n, c) adds to the deviations. Rows
        whose past is not whole are zero."""
        out = values.copy()
        for lag in range(1, self.coefficients.shape[1] + 1):
            weight = self.coefficients[:, lag - 1]
            out[lag:] -= values[:-lag] * (weight if values.ndim == 2 else weight[:, None])
        scale = np.hypot(self.deviations, slack)
        out /= scale if values.ndim == 2 else scale[:, :, None]
        out[~whole_past(grid, self.coefficients.shape[1])] = 0.0
        return out


def whole_past(grid: Grid, order: int) -> NDArray[np.bool_]:
    """Instants with `order` + 1 instants of their stretch before them (one more: differences begin late)."""
    since = np.arange(len(grid)) - np.maximum.accumulate(np.where(grid.first, np.arange(len(grid)), 0))
    whole: NDArray[np.bool_] = since > order
    return whole


def autocovariance(values: Array, grid: Grid, order: int = ORDER) -> Array:
    """Sums of lagged products of residuals, (c, p + 1), over one log, and no product across a gap."""
    since = np.arange(len(grid)) - np.maximum.accumulate(np.where(grid.first, np.arange(len(grid)), 0))
    sums = np.empty((values.shape[1], order + 1))
    for lag in range(order + 1):
        inside = since >= lag + 1
        sums[:, lag] = np.sum(values[inside] * np.roll(values, lag, axis=0)[inside], axis=0) / max(1, inside.sum())
    return sums


def noise_model(names: tuple[str, ...], covariance: Array) -> NoiseModel:
    """The noise model of autocovariances, (c, p + 1), by the Yule-Walker equations."""
    coefficients = np.empty((len(names), covariance.shape[1] - 1))
    deviations = np.empty(len(names))
    for i, row in enumerate(covariance):
        first = row.copy()
        first[0] = max(row[0] * (1.0 + RIDGE), 1e-30)
        coefficients[i] = solve_toeplitz(first[:-1], first[1:])
        deviations[i] = np.sqrt(max(first[0] - coefficients[i] @ first[1:], RIDGE * first[0]))
    return NoiseModel(names, coefficients, deviations)
