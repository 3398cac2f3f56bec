"""All that hypotheses need of a log: one matrix of inner products of whitened columns, block by block.

Columns are nuisances, signatures of effects, cells without physics, and the residuals themselves. Every fit, joint
fit, held-out fit and distance between two explanations is then algebra on small matrices (generalized least
squares; priors enter as rows of data: Rasmussen and Williams 2006, §2.7).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.units import Array

BLOCKS = 8
CONTAINED = 0.98  # share of a column's sum of squares that others must make up to contain it
SINGULAR = 1e-6  # share of a column that the others must leave for it to be one of its own


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
class NormalEquations:
    """Inner products by block of time, (b, m, m): `nuisances` columns first, then signatures and cells, the
    residual last; `prior` holds the nuisances' prior precisions, `inner` the products with the nuisances taken
    out."""

    products: Array
    nuisances: int
    prior: Array
    inner: Array

    def fit(self, columns: Sequence[int], given: Sequence[int] = ()) -> Fit:
        """Fit columns, with others `given` free as well; the gain is over those alone."""
        sizes, covariance, gain = _solve(self.inner, [*given, *columns])
        base = _solve(self.inner, given)[2]
        first = len(given)
        return Fit(tuple(columns), sizes[first:], covariance[first:, first:], max(0.0, gain - base))

    def scores(self, columns: Sequence[int], given: Sequence[int] = ()) -> Array:
        """Size over its deviation of each column on its own, with others `given` free; 0 where they leave
        nothing."""
        chosen, taken = list(columns), list(given)
        power, product = np.diag(self.inner)[chosen].copy(), self.inner[chosen, -1].copy()
        whole = power.copy()
        if taken:
            inverse = _solve(self.inner, taken)[1]
            across = self.inner[np.ix_(chosen, taken)]
            power -= np.einsum("ij,jk,ik->i", across, inverse, across)
            product -= across @ inverse @ self.inner[taken, -1]
        usable = power > SINGULAR * np.maximum(whole, 1e-300)
        return np.where(usable, product / np.sqrt(np.where(usable, power, 1.0)), 0.0)

    def gain_along(self, columns: Sequence[int], proportions: Sequence[float], given: Sequence[int] = ()) -> float:
        """The gain of columns in fixed proportions, one size for all, with others `given` free; 0 where these leave
        nothing."""
        inner, w, chosen = self.inner, np.asarray(proportions), list(columns)
        power = w @ inner[np.ix_(chosen, chosen)] @ w
        product, whole = w @ inner[chosen, -1], power
        if given:
            taken = list(given)
            across = w @ inner[np.ix_(chosen, taken)]
            inverse = _solve(inner, taken)[1]
            power = power - across @ inverse @ across
            product = product - across @ inverse @ inner[taken, -1]
        return float(product**2 / power) if power > SINGULAR * whole else 0.0

    def contains(self, columns: Sequence[int], others: Sequence[int]) -> bool:
        """Whether some columns can make up the others, nuisances being free."""
        inner, chosen = self.inner, list(columns)
        inverse = _solve(inner, chosen)[1]
        across = inner[np.ix_(list(others), chosen)]
        made = np.einsum("ij,jk,ik->i", across, inverse, across)
        return bool(np.all(made > CONTAINED * np.diag(inner)[list(others)]))

    def left(self, columns: Sequence[int]) -> float:
        """Sum of squares left after fitting nuisances and some columns."""
        return float(self.inner[-1, -1] - _solve(self.inner, columns)[2])

    def held_out_gain(self, columns: Sequence[int], given: Sequence[int] = ()) -> float:
        """What the columns save in each block when sizes and nuisances are fitted to the other blocks, summed, and
        what they save in the priors, which are data of no block."""
        total = self.products.sum(axis=0)
        stretched = self.nuisance_sizes(given) ** 2 - self.nuisance_sizes([*given, *columns]) ** 2
        return float(self.prior @ stretched) + sum(
            self._misfit(here, total - here, given) - self._misfit(here, total - here, [*given, *columns])
            for here in self.products
        )

    def _misfit(self, here: Array, others: Array, columns: Sequence[int]) -> float:
        """Sum of squares of a block under what the other blocks say."""
        k = self.nuisances
        used = [*range(k), *(k + c for c in columns)]
        normal = others[np.ix_(used, used)]
        normal[np.arange(k), np.arange(k)] += self.prior
        answer = _solve_scaled(normal, others[used, -1])
        return float(here[-1, -1] - 2.0 * answer @ here[used, -1] + answer @ here[np.ix_(used, used)] @ answer)

    def nuisance_sizes(self, columns: Sequence[int] = ()) -> Array:
        """The nuisances fitted together with some columns."""
        k = self.nuisances
        used = [*range(k), *(k + c for c in columns)]
        total = self.products.sum(axis=0)
        normal = total[np.ix_(used, used)]
        normal[np.arange(k), np.arange(k)] += self.prior
        return _solve_scaled(normal, total[used, -1])[:k]


def equations_from(products: Array, nuisances: int, deviations: Array) -> NormalEquations:
    """Evidence from inner products and the nuisances' prior deviations."""
    prior = 1.0 / deviations**2
    total, k = products.sum(axis=0), nuisances
    normal = total[:k, :k] + np.diag(prior)
    taken = np.stack([_solve_scaled(normal, column) for column in total[:k, k:].T], axis=1)
    return NormalEquations(products, nuisances, prior, total[k:, k:] - total[k:, :k] @ taken)


def inner_products(columns: Array, residual: Array, blocks: int = BLOCKS) -> Array:
    """Inner products by block, (b, k + 1, k + 1), of whitened columns (n, c, k) and the residual (n, c)."""
    every = np.concatenate([columns, residual[:, :, None]], axis=2)
    parts = [part.reshape(-1, every.shape[2]) for part in np.array_split(every, blocks)]
    return np.stack([part.T @ part for part in parts])


def _solve(inner: Array, columns: Sequence[int]) -> tuple[Array, Array, float]:
    """Sizes, covariance and gain of columns on inner products whose last column is the residual."""
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
    solved = np.linalg.lstsq(normal * np.outer(scale, scale), right * scale, rcond=1e-13)[0]
    return np.asarray(solved * scale)
