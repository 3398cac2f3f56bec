"""Fit the free parameters alone: the remaining residuals are noise, and a gap where there is one."""

from dataclasses import dataclass

import numpy as np

from pitotbench.estimate.robust_scale import robust_deviation
from pitotbench.reconcile.residuals.free_parameters import FreeParameters
from pitotbench.units import Array, Booleans

SCALINGS = 3  # rounds of scaling the channels against each other; their noise is not known yet
TINY = 1e-12  # added to a scale: a channel without any change must not divide by zero


@dataclass(frozen=True, slots=True)
class ParameterFit:
    """Sizes of the free parameters, (k,), and the residuals without them, (n, c)."""

    sizes: Array
    residuals: Array


def fit_free_parameters(values: Array, free: FreeParameters, usable: Booleans) -> ParameterFit:
    """Fit the free parameters to residuals (n, c) by least squares with priors.

    Only instants and channels that are `usable`, (n, c), enter. Each channel is scaled by the robust deviation of
    its remaining residuals.
    """
    columns, remaining, scale = free.columns, values, values.std(axis=0) + TINY
    sizes = np.zeros(columns.shape[2])
    for _ in range(SCALINGS):
        design = (columns * (usable / scale)[:, :, None]).reshape(-1, columns.shape[2])
        normal = design.T @ design + np.diag(1.0 / free.deviations**2)
        sizes = np.linalg.solve(normal, design.T @ (values * usable / scale).ravel())
        remaining = values - columns @ sizes
        scale = robust_deviation(remaining) + TINY
    return ParameterFit(sizes, remaining)
