"""All that hypotheses need of a log: one matrix of inner products of whitened columns, block by block.

Columns are nuisances, signatures of effects and the residuals themselves. Every fit, joint fit, held-out fit and
distance between two explanations is then algebra on small matrices (generalized least squares with priors: Rasmussen
and Williams 2006, §2.7, for the prior as rows of data).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.units import Array

BLOCKS = 8
SINGULAR = 1e-9  # share of a column that nuisances leave, below which it is nothing of its own

Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Fit:
    """Sizes of some columns with their covariance, nuisances free; `gain` is the fall of the sum of squares."""

    columns: tuple[int, ...]
    sizes: Array
    covariance: Array
    gain: float

    @property
    def deviations(self) -> Array:
        """Standard deviation of each size."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True, slots=True)
class Evidence:
    """Inner products by block of time, (b, m, m): first `nuisances` columns, then signatures, the last the residual.

    `prior` holds the nuisances' prior precisions.
    """

    products: Array
    nuisances: int
    prior: Array

    @property
    def signatures(self) -> int:
        """How many columns stand for effects."""
        return self.products.shape[1] - self.nuisances - 1

    def reduced(self, keep: Sequence[int] | None = None) -> Array:
        """Inner products of signatures and residual with the nuisances taken out, (s + 1, s + 1), over the blocks
        to keep (all, if not given)."""
        total = self.products.sum(axis=0) if keep is None else self.products[list(keep)].sum(axis=0)
        k = self.nuisances
        normal = total[:k, :k] + np.diag(self.prior)
        return np.asarray(total[k:, k:] - total[k:, :k] @ np.linalg.solve(normal, total[:k, k:]))

    def fit(self, columns: Sequence[int], given: Sequence[int] = (), keep: Sequence[int] | None = None) -> Fit:
        """Fit signature columns, with others `given` free as well; the gain is over those alone."""
        inner = self.reduced(keep)
        full, base = _solve(inner, [*given, *columns]), _solve(inner, given)
        first = len(given)
        return Fit(
            tuple(columns), full[0][first:], full[1][first:, first:], max(0.0, full[2] - base[2])
        )

    def left(self, columns: Sequence[int]) -> float:
        """Sum of squares left after fitting nuisances and signature columns."""
        inner = self.reduced()
        return float(inner[-1, -1] - _solve(inner, columns)[2])

    def held_out_gain(self, columns: Sequence[int], given: Sequence[int] = ()) -> float:
        """What the columns save in each block when sizes and nuisances are fitted to the other blocks, summed."""
        saved = 0.0
        for block in range(len(self.products)):
            others = [b for b in range(len(self.products)) if b != block]
            saved += self._misfit(block, others, given) - self._misfit(block, others, [*given, *columns])
        return saved

    def _misfit(self, block: int, others: Sequence[int], columns: Sequence[int]) -> float:
        """Sum of squares of a block under what the other blocks say."""
        k = self.nuisances
        used = [*range(k), *(k + c for c in columns)]
        total = self.products[list(others)].sum(axis=0)
        normal = total[np.ix_(used, used)]
        normal[np.arange(k), np.arange(k)] += self.prior
        answer = _solve_scaled(normal, total[used, -1])
        here = self.products[block]
        return float(here[-1, -1] - 2.0 * answer @ here[used, -1] + answer @ here[np.ix_(used, used)] @ answer)


def _solve(inner: Array, columns: Sequence[int]) -> tuple[Array, Array, float]:
    """Sizes, covariance and gain of signature columns on reduced inner products."""
    chosen = list(columns)
    if not chosen:
        return np.zeros(0), np.zeros((0, 0)), 0.0
    normal, right = inner[np.ix_(chosen, chosen)], inner[chosen, -1]
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    values, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    usable = values > SINGULAR
    inverse = (vectors[:, usable] / values[usable]) @ vectors[:, usable].T * np.outer(scale, scale)
    sizes = inverse @ right
    return sizes, inverse, float(sizes @ right)


def _solve_scaled(normal: Array, right: Array) -> Array:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    solved = np.linalg.lstsq(normal * np.outer(scale, scale), right * scale, rcond=1e-12)[0]
    return np.asarray(solved * scale)


def gather(nuisances: Array, prior: Array, signatures: Array, residual: Array, blocks: int = BLOCKS) -> Evidence:
    """The evidence of whitened columns: nuisances (n, c, k), signatures (n, c, s), residual (n, c)."""
    columns = np.concatenate([nuisances, signatures, residual[:, :, None]], axis=2)
    parts = np.array_split(columns, blocks)
    products = np.stack([np.einsum("ncj,nck->jk", part, part, optimize=True) for part in parts])
    return Evidence(products, nuisances.shape[2], 1.0 / prior**2)
