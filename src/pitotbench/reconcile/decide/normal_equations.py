"""The normal equations of a log: inner products of whitened columns, block by block of time.

Columns are the free parameters, the signatures of effects, the cells, and the residuals. Every fit, joint fit and
held-out fit is then algebra on small matrices (generalized least squares; priors enter as rows of data: Rasmussen
and Williams 2006, §2.7).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.units import Array

BLOCKS = 8  # of time: each is left out once, and holds a phase of a maneuver
SINGULAR = 1e-6  # share of a column that the others must not reproduce for it to be independent
SMALLEST = 1e-300  # sum of squares of an empty column, so that it can be divided by
ROUNDING = 1e-13  # singular values below this share of the largest are rounding


@dataclass(frozen=True, slots=True)
class Fit:
    """Sizes of some columns, (k,), with their covariance, (k, k), fitted together with the free parameters.

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
    """Inner products by block of time, (b, m, m).

    The first `free` columns are the free parameters, with the prior precisions `prior`, (k,). Signatures and cells
    follow; the residual is last. `inner` holds the sums over all blocks after elimination of the free parameters,
    so that its columns count from the first signature.
    """

    products: Array
    free: int
    prior: Array
    inner: Array

    def fit(self, columns: Sequence[int], given: Sequence[int] = ()) -> Fit:
        """Fit columns together with others that are `given`; the gain is over the given ones alone."""
        sizes, covariance, gain = _solve(self.inner, [*given, *columns])
        base = _solve(self.inner, given)[2]
        first = len(given)
        return Fit(tuple(columns), sizes[first:], covariance[first:, first:], max(0.0, gain - base))

    def scores(self, columns: Sequence[int], given: Sequence[int] = ()) -> Array:
        """Return the size of each column alone over its deviation, with others `given` in the fit.

        It is 0 for a column that the given ones reproduce.
        """
        chosen, others = list(columns), list(given)
        power, product = np.diag(self.inner)[chosen].copy(), self.inner[chosen, -1].copy()
        whole = power.copy()
        if others:
            inverse = _solve(self.inner, others)[1]
            across = self.inner[np.ix_(chosen, others)]
            power -= np.einsum("ij,jk,ik->i", across, inverse, across)
            product -= across @ inverse @ self.inner[others, -1]
        usable = power > SINGULAR * np.maximum(whole, SMALLEST)
        return np.where(usable, product / np.sqrt(np.where(usable, power, 1.0)), 0.0)

    def remaining(self, columns: Sequence[int]) -> float:
        """Return the sum of squares that remains after a fit of the free parameters and some columns."""
        return float(self.inner[-1, -1] - _solve(self.inner, columns)[2])

    def held_out_gain(self, columns: Sequence[int], given: Sequence[int] = ()) -> float:
        """Return the fall of the sum of squares by some columns in blocks that the fit does not use.

        For each block, sizes and free parameters are fitted to the other blocks. The fall in the priors, which are
        data of no block, is added once.
        """
        total = self.products.sum(axis=0)
        in_priors = self.free_sizes(given) ** 2 - self.free_sizes([*given, *columns]) ** 2
        return float(self.prior @ in_priors) + sum(
            self._misfit(here, total - here, given) - self._misfit(here, total - here, [*given, *columns])
            for here in self.products
        )

    def _misfit(self, here: Array, others: Array, columns: Sequence[int]) -> float:
        """Sum of squares of a block with sizes fitted to the other blocks."""
        k = self.free
        used = [*range(k), *(k + c for c in columns)]
        normal = others[np.ix_(used, used)]
        normal[np.arange(k), np.arange(k)] += self.prior
        sizes = _solve_scaled(normal, others[used, -1])
        return float(here[-1, -1] - 2.0 * sizes @ here[used, -1] + sizes @ here[np.ix_(used, used)] @ sizes)

    def free_sizes(self, columns: Sequence[int] = ()) -> Array:
        """Return the sizes of the free parameters, (k,), fitted together with some columns."""
        k = self.free
        used = [*range(k), *(k + c for c in columns)]
        total = self.products.sum(axis=0)
        normal = total[np.ix_(used, used)]
        normal[np.arange(k), np.arange(k)] += self.prior
        return _solve_scaled(normal, total[used, -1])[:k]


def equations_from(products: Array, free: int, deviations: Array) -> NormalEquations:
    """Return the equations of inner products, (b, m, m), and the prior deviations of the free parameters, (k,)."""
    prior = 1.0 / deviations**2
    total, k = products.sum(axis=0), free
    normal = total[:k, :k] + np.diag(prior)
    eliminated = np.stack([_solve_scaled(normal, column) for column in total[:k, k:].T], axis=1)
    return NormalEquations(products, free, prior, total[k:, k:] - total[k:, :k] @ eliminated)


def inner_products(columns: Array, residual: Array, blocks: int = BLOCKS) -> Array:
    """Return inner products by block, (b, k + 1, k + 1), of whitened columns (n, c, k) and the residual (n, c)."""
    return products_of(np.concatenate([columns, residual[:, :, None]], axis=2), blocks)


def products_of(every: Array, blocks: int = BLOCKS) -> Array:
    """Return inner products by block, (b, m, m), of whitened columns, (n, c, m); the residual is the last."""
    parts = [part.reshape(-1, every.shape[2]) for part in np.array_split(every, blocks)]
    return np.stack([part.T @ part for part in parts])


def _solve(inner: Array, columns: Sequence[int]) -> tuple[Array, Array, float]:
    """Sizes, covariance and gain of columns on inner products whose last column is the residual."""
    chosen = list(columns)
    if not chosen:
        return np.zeros(0), np.zeros((0, 0)), 0.0
    normal, right = inner[np.ix_(chosen, chosen)], inner[chosen, -1]
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), SMALLEST))
    values, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    usable = values > SINGULAR
    inverse = (vectors[:, usable] / values[usable]) @ vectors[:, usable].T * np.outer(scale, scale)
    sizes = inverse @ right
    return sizes, inverse, float(sizes @ right)


def _solve_scaled(normal: Array, right: Array) -> Array:
    """Sizes of normal equations that may be singular, each column scaled to 1."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), SMALLEST))
    solved = np.linalg.lstsq(normal * np.outer(scale, scale), right * scale, rcond=ROUNDING)[0]
    return np.asarray(solved * scale)
