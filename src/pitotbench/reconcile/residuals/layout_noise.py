"""The noise of a log that is laid out: learned from it, scaled to it, and applied to its columns."""

from dataclasses import replace

import numpy as np

from pitotbench.estimate.robust_scale import robust_deviation
from pitotbench.reconcile.decide.normal_equations import NormalEquations, equations_from, products_of
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.parameter_fit import fit_free_parameters
from pitotbench.reconcile.residuals.whitening import ORDER, NoiseModel, learned
from pitotbench.units import Array

SAME_SHAPE = 1e-9  # singular value of the cells' shapes below which two of them are the same


def noise_residuals(layout: Layout) -> Array:
    """Return the residuals without free parameters, (n, c), from which the noise is learned."""
    used = layout.used
    return np.where(used, fit_free_parameters(layout.residuals.values, layout.free, used).residuals, 0.0)


def noise_of_log(layout: Layout) -> NoiseModel:
    """Return the noise that the log itself shows, once free parameters and the means of the cells are fitted.

    So a gap that has a place does not count as noise. In a short log the cells take a part of what wanders.
    """
    return learned(layout.residuals.names, [(_without_cells(layout), layout.grid, layout.residuals.slack)])


def shortness_of(layout: Layout) -> float:
    """Return how many times longer a log should be for the noise that it shows itself: 1 is some 350 instants."""
    wanted = THRESHOLDS.instants_a_size * (layout.shapes.shape[1] + ORDER)
    return float(wanted / len(layout.grid))


def scaled_to(noise: NoiseModel, layout: Layout) -> NoiseModel:
    """Return a noise model with the level of innovations of this log, by their median, where that is higher."""
    innovations = noise.innovations(_without_cells(layout), layout.grid, layout.residuals.slack)
    used = innovations[np.any(innovations != 0.0, axis=1)]
    level = robust_deviation(used)
    most = THRESHOLDS.noise_above_null
    if layout.setting.pressure_step:  # a coarse pressure rests for long, then steps: no median shows it
        level, most = np.maximum(level, used.std(axis=0)), np.inf
    return replace(noise, deviations=noise.deviations * np.clip(level, 1.0, most))


def whitened_equations(layout: Layout, noise: NoiseModel, with_cells: bool = True) -> NormalEquations:
    """Return the normal equations of a log under a noise model.

    Columns are the free parameters, the signatures in their order, and the cells in theirs. The cells are four of
    five columns: who asks nothing of them leaves them out.
    """
    products = products_of(whitened_columns(layout, noise, with_cells))
    return equations_from(products, layout.free.columns.shape[2], layout.free.deviations)


def whitened_columns(layout: Layout, noise: NoiseModel, with_cells: bool = True) -> Array:
    """Return the free parameters, the signatures, the cells and, last, the residuals, all whitened, (n, c, m)."""
    place = layout.grid, layout.residuals.slack
    whiten = noise.whitener(*place)
    columns = [s.column[:, :, None] for s in layout.signatures]
    dense = whiten(np.concatenate([layout.free.columns, *columns], axis=2))
    cells = [noise.whiten_alone(layout.shapes, *place)] if with_cells else []
    return np.concatenate([dense, *cells, whiten(layout.residuals.values)[:, :, None]], axis=2)


def _without_cells(layout: Layout) -> Array:
    """Residuals without free parameters and without the means of the cells, (n, c).

    So a gap that has a place does not count as noise.
    """
    residuals = noise_residuals(layout)
    used = layout.used[:, :1].astype(np.float64)
    shapes = np.concatenate([layout.shapes, np.ones((len(residuals), 1))], axis=1) * used
    return np.asarray(residuals - shapes @ np.linalg.lstsq(shapes, residuals * used, rcond=SAME_SHAPE)[0])
