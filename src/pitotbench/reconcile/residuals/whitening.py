"""Noise of the residual channels: an autoregression a channel, and the correlation of what it cannot foresee.

The order is high enough for gusts, vibration of the loops and differenced GPS noise alike; nothing is assumed about
their spectra. Gusts and noisy sensors show in several channels at once: what they leave there together is weighed
together. Learned on flights without an effect, or from the log itself where there are none (Lütkepohl, New
Introduction to Multiple Time Series Analysis, 2005, ch. 3; past of each channel on its own here).
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz

from pitotbench.reconcile.residuals.grid import Grid
from pitotbench.units import Array

ORDER = 12
RIDGE = 1e-4  # share of white noise added, so that the equations stay well posed
OWN = 0.02  # share of each channel's innovations that is taken to be its own


@dataclass(frozen=True, slots=True)
class NoiseModel:
    """Prediction coefficients of each channel, (c, p), the deviations of what they leave, (c,), and how that is
    correlated between channels, (c, c)."""

    names: tuple[str, ...]
    coefficients: Array
    deviations: Array
    correlation: Array

    def innovations(self, values: Array, grid: Grid, slack: Array) -> Array:
        """Innovations of each channel over their deviations, of (n, c) or (n, c, k); `slack` (n, c) adds to the
        deviations. Rows whose past is not whole are zero."""
        out = values.copy()
        for lag in range(1, self.coefficients.shape[1] + 1):
            weight = self.coefficients[:, lag - 1]
            out[lag:] -= values[:-lag] * (weight if values.ndim == 2 else weight[:, None])
        scale = np.hypot(self.deviations, slack)
        out /= scale if values.ndim == 2 else scale[:, :, None]
        out[~whole_past(grid, self.coefficients.shape[1])] = 0.0
        return out

    def apart(self, innovations: Array, slack: Array) -> Array:
        """Innovations of all channels, (n, c, k), as combinations that are uncorrelated at each instant; slack is a
        channel's own."""
        share = self.deviations / np.hypot(self.deviations, slack)
        usual = np.all(share > 1.0 - 1e-6, axis=1)
        out = np.empty_like(innovations)
        out[usual] = np.linalg.inv(np.linalg.cholesky(self.correlation)) @ innovations[usual]
        s = share[~usual]
        if len(s):
            joint = self.correlation * s[:, :, None] * s[:, None, :]
            place = np.arange(len(self.names))
            joint[:, place, place] = 1.0
            out[~usual] = np.linalg.solve(np.linalg.cholesky(joint), innovations[~usual])
        return out

    def given_others(self, innovations: Array) -> Array:
        """Innovations (n, c), each less what the other channels tell of it at that instant, over its deviation."""
        precision = np.linalg.inv(self.correlation)
        return np.asarray(innovations @ precision / np.sqrt(np.diag(precision)))

    def whiten(self, values: Array, grid: Grid, slack: Array) -> Array:
        """Uncorrelated innovations of deviation one, of (n, c) or (n, c, k)."""
        found = self.innovations(values, grid, slack)
        return self.apart(found[:, :, None], slack)[:, :, 0] if values.ndim == 2 else self.apart(found, slack)

    def whiten_alone(self, shapes: Array, grid: Grid, slack: Array) -> Array:
        """Shapes (n, s) that each stand in one channel only, whitened: (n, c, c·s) in the order of channels."""
        (n, s), c = shapes.shape, len(self.names)
        own = self.innovations(np.broadcast_to(shapes[:, None, :], (n, c, s)), grid, slack)
        out = np.zeros((n, c, c, s))
        out[:, np.arange(c), np.arange(c)] = own
        return self.apart(out.reshape(n, c, c * s), slack)


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


def learned(names: tuple[str, ...], logs: Iterable[tuple[Array, Grid, Array]]) -> NoiseModel:
    """The noise model of some logs, each its residuals without nuisances (n, c), its instants and its slack."""
    logs = list(logs)
    alone = _alone(names, np.mean([autocovariance(values, grid) for values, grid, _ in logs], axis=0))
    seen = [alone.innovations(values, grid, slack) for values, grid, slack in logs]
    products = sum((found.T @ found for found in seen), np.zeros((len(names), len(names))))
    spread = np.sqrt(np.maximum(np.diag(products), 1e-30))
    correlation = products / np.outer(spread, spread)
    return replace(alone, correlation=(1.0 - OWN) * correlation + OWN * np.eye(len(names)))


def _alone(names: tuple[str, ...], covariance: Array) -> NoiseModel:
    """The noise model of autocovariances, (c, p + 1), by the Yule-Walker equations, each channel on its own."""
    coefficients = np.empty((len(names), covariance.shape[1] - 1))
    deviations = np.empty(len(names))
    for i, row in enumerate(covariance):
        first = row.copy()
        first[0] = max(row[0] * (1.0 + RIDGE), 1e-30)
        coefficients[i] = solve_toeplitz(first[:-1], first[1:])
        deviations[i] = np.sqrt(max(first[0] - coefficients[i] @ first[1:], RIDGE * first[0]))
    return NoiseModel(names, coefficients, deviations, np.eye(len(names)))
