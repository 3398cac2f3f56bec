"""The normal equations of whitened columns, and the noise that whitens them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench.estimation.information import Information, SizePosterior
from pitotbench.normal_equations import ROUNDING
from pitotbench.reconciliation.free_parameters import fit_free_parameters
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.noise import ORDER, NoiseModel, learned
from pitotbench.reconciliation.residuals import ATTITUDE_RATES
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.scatter import robust_deviation
from pitotbench.units import Array

Integers = NDArray[np.intp]

FOLDS = 8  # sets of segments of the log, from all over it, of which each is left out once
SEGMENT = 8.0  # s: a part that is left out whole; short, for a turn may come only once
INSTANTS = 16  # of a part


@dataclass(frozen=True, slots=True)
class Fit:
    """Sizes of some columns, (k,), fitted with the free parameters, and their covariance (k, k).

    `gain` is the fall of the sum of squares by these columns.
    """

    columns: tuple[int, ...]
    sizes: Array
    covariance: Array
    gain: float

    @property
    def deviations(self) -> Array:
        """Standard deviation of each size."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True, slots=True)
class NormalEquations:
    """Inner products by fold, a set of short segments from all over the log, (b, m, m).

    Columns are the free parameters, the signatures of effects, the cells, and the residuals. Every
    fit, joint fit and held-out fit is then algebra on small matrices (generalized least squares;
    priors enter as rows of data: Rasmussen and Williams 2006, §2.7).

    The first `free` columns are the free parameters, with the prior precisions `prior`, (k,).
    Signatures and cells follow; the residual is last. `inner` holds the sums over all blocks after
    elimination of the free parameters, so that its columns count from the first signature.
    """

    products: Array
    free: int
    prior: Array
    inner: Array

    def fit(self, columns: Sequence[int], given: Sequence[int] = ()) -> Fit:
        """Fit columns together with others that are `given`; the gain is over these alone."""
        found, first = Information(self.inner).posterior([*given, *columns]), len(given)
        gain = Information(self.inner).gain(columns, given)
        return Fit(tuple(columns), found.mean[first:], found.covariance[first:, first:], gain)

    def scores(self, columns: Sequence[int], given: Sequence[int] = ()) -> Array:
        """Return the score of each column, see `Information.scores`."""
        return Information(self.inner).scores(columns, given)

    def held_out_gain(self, columns: Sequence[int], given: Sequence[int] = ()) -> float:
        """Return the fall of the sum of squares by some columns in blocks left out of the fit.

        For each block, sizes and free parameters are fitted to the other blocks. The fall in the
        priors, which are data of no block, is added once.
        """
        total = self.products.sum(axis=0)
        in_priors = self.free_sizes(given) ** 2 - self.free_sizes([*given, *columns]) ** 2
        return float(self.prior @ in_priors) + sum(
            self._misfit(here, total - here, given)
            - self._misfit(here, total - here, [*given, *columns])
            for here in self.products
        )

    def _misfit(self, here: Array, others: Array, columns: Sequence[int]) -> float:
        """Sum of squares of a block with sizes fitted to the other blocks."""
        sizes = self._with_free(others, columns).mean
        return float(Information(here).less(self._used(columns), sizes).inner[-1, -1])

    def _used(self, columns: Sequence[int]) -> list[int]:
        """The free parameters and some columns, among all."""
        return [*range(self.free), *(self.free + c for c in columns)]

    def _with_free(self, products: Array, columns: Sequence[int]) -> SizePosterior:
        """The posterior of the free parameters and of some columns, whose priors are flat."""
        deviations = np.append(self.prior**-0.5, np.full(len(columns), np.inf))
        return Information(products).posterior(self._used(columns), deviations, ROUNDING)

    def free_sizes(self, columns: Sequence[int] = ()) -> Array:
        """Return the sizes of the free parameters, (k,), fitted together with some columns."""
        return self.free_estimates(columns)[0]

    def free_estimates(self, columns: Sequence[int] = ()) -> tuple[Array, Array]:
        """Return the free parameters' sizes and deviations, (k,) each, fitted with some columns."""
        k, found = self.free, self._with_free(self.products.sum(axis=0), columns)
        return found.mean[:k], np.sqrt(np.diag(found.covariance))[:k]


def equations_from(products: Array, free: int, deviations: Array) -> NormalEquations:
    """Return the equations of inner products, (b, m, m), and prior deviations, (k,).

    The deviations are those of the free parameters.
    """
    whole = Information(products.sum(axis=0))
    rest = range(free, len(whole.inner) - 1)
    inner = whole.given(range(free), deviations, rest)[0].inner
    return NormalEquations(products, free, 1.0 / deviations**2, inner)


def inner_products(columns: Array, residual: Array) -> Array:
    """Return inner products of whitened columns and the residual in one fold.

    Columns (n, c, k) and a residual (n, c) give (1, k + 1, k + 1).
    """
    every = np.concatenate([columns, residual[:, :, None]], axis=2)
    return products_of(every, np.zeros(len(every), dtype=np.intp))


def products_of(every: Array, fold: Integers) -> Array:
    """Return inner products by fold, (b, m, m), of whitened columns, (n, c, m).

    The residual is last; `fold` (n,) is the number of the fold of each instant.
    """
    parts = [every[fold == n].reshape(-1, every.shape[2]) for n in np.unique(fold)]
    return np.stack([part.T @ part for part in parts])


def folds_of(layout: Layout) -> Integers:
    """Return the fold of each instant of a log, (n,)."""
    time = layout.track.time[layout.grid.rows]
    segment = min(SEGMENT, INSTANTS * layout.grid.step)
    folds: Integers = ((time - time[0]) / segment).astype(np.intp) % FOLDS
    return folds


SAME_SHAPE = 1e-9  # singular value of the cells' shapes below which two of them are the same


def noise_residuals(layout: Layout) -> Array:
    """Return the residuals without free parameters, (n, c), from which the noise is learned."""
    used = layout.used
    return np.where(
        used, fit_free_parameters(layout.residuals.values, layout.free, used).residuals, 0.0
    )


def noise_of_log(layout: Layout) -> NoiseModel:
    """Return the noise that the log itself shows beside free parameters and means of cells.

    So a gap that has a place does not count as noise. In a short log the cells take a part of what
    wanders. The change of an angle shares its noise with the angle, but over some seconds alone:
    taken for all times, it would make the mean of a slow channel too sure.
    """
    data = _without_cells(layout), layout.grid, layout.residuals.slack
    return learned(layout.residuals.names, [data]).apart((*ATTITUDE_RATES, "climb_rate"))


def shortness_of(layout: Layout) -> float:
    """Return how many times longer a log should be for its own noise; 1 is some 350 instants."""
    wanted = THRESHOLDS.instants_a_size * (layout.shapes.shape[1] + ORDER)
    return float(wanted / len(layout.grid))


def scaled_to(noise: NoiseModel, layout: Layout) -> NoiseModel:
    """Return a noise model with the innovations' level of this log, where that is higher.

    The level is judged by their median. Maneuvers keep the noise model, which is their own.
    """
    if layout.setting.maneuvers:
        return noise
    innovations = noise.innovations(_without_cells(layout), layout.grid, layout.residuals.slack)
    used = innovations[np.any(innovations != 0.0, axis=1)]
    level = robust_deviation(used)
    most = THRESHOLDS.noise_above_null
    if (
        layout.setting.pressure_step
    ):  # a coarse pressure rests for long, then steps: no median shows it
        level, most = np.maximum(level, used.std(axis=0)), np.inf
    return replace(noise, deviations=noise.deviations * np.clip(level, 1.0, most))


def whitened_equations(
    layout: Layout, noise: NoiseModel, with_cells: bool = True
) -> NormalEquations:
    """Return the normal equations of a log under a noise model.

    Columns are the free parameters, the signatures in their order, and the cells in theirs. The
    cells are four of five columns: who asks nothing of them leaves them out.
    """
    products = products_of(whitened_columns(layout, noise, with_cells), folds_of(layout))
    return equations_from(products, layout.free.columns.shape[2], layout.free.deviations)


def whitened_columns(layout: Layout, noise: NoiseModel, with_cells: bool = True) -> Array:
    """Return all columns of a log whitened, the residuals last, (n, c, m).

    The columns are the free parameters, the signatures, the cells and the residuals.
    """
    place = layout.grid, layout.residuals.slack
    whiten = noise.whitener(*place)
    columns = [s.column[:, :, None] for s in layout.signatures]
    dense = whiten(np.concatenate([layout.free.columns, *columns], axis=2))
    cells = [noise.whiten_alone(layout.shapes, *place)] if with_cells else []
    return np.concatenate([dense, *cells, whiten(layout.residuals.values)[:, :, None]], axis=2)


def _without_cells(layout: Layout) -> Array:
    """Return residuals less free parameters and means of the cells, (n, c).

    So a gap that has a place does not count as noise.
    """
    residuals = noise_residuals(layout)
    used = layout.used[:, :1].astype(np.float64)
    shapes = np.concatenate([layout.shapes, np.ones((len(residuals), 1))], axis=1) * used
    return np.asarray(
        residuals - shapes @ np.linalg.lstsq(shapes, residuals * used, rcond=SAME_SHAPE)[0]
    )


def with_form_error(covariance: Array, sizes: Sequence[float]) -> Array:
    """Return the covariance of sizes, (k, k), with the errors of form and method.

    The form of an effect in another log adds to each size, and so does the method.
    """
    share = np.hypot(THRESHOLDS.form_error, THRESHOLDS.size_error)
    return np.asarray(covariance + np.diag((share * np.asarray(sizes)) ** 2))
