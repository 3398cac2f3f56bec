"""What rows say of the sizes of some columns: the evidence of a linear Gaussian model.

Rows are r = X s + noise, with white noise of variance 1 and sizes s of prior N(0, P). With A = XᵀX
and b = Xᵀr, their probability relative to that without the columns is ln Z = ½ bᵀ (P⁻¹ + A)⁻¹ b −
½ ln det(I + P A), the gain of a ridge regression less an Occam factor (MacKay, Information Theory,
Inference, and Learning Algorithms, 2003, ch. 28; Rasmussen and Williams 2006, §2.7). Inner products
are all that is needed of the rows, and those of independent rows add.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.linalg.lapack import dpotrf, dpotrs

from pitotbench.normal_equations import inverse
from pitotbench.units import Array

# Of columns that are each scaled to 1, the share of the strongest axis below which an axis is left
# out: what the others must not reproduce of one for it to be independent.
SINGULAR = 1e-6


@dataclass(frozen=True, slots=True)
class SizePosterior:
    """The posterior of some sizes: mean (k,), covariance (k, k), and log evidence.

    With flat priors the evidence is half the fall of the sum of squares.
    """

    mean: Array
    covariance: Array
    log_evidence: float


@dataclass(frozen=True, slots=True)
class Information:
    """The inner products of rows, (m + 1, m + 1), in units of the noise, the residual last.

    Priors are normal, around zero, with a deviation for each column; an infinite one is flat.
    """

    inner: Array

    def __add__(self, other: "Information") -> "Information":
        return Information(self.inner + other.inner)

    def placed(self, columns: Sequence[int] | NDArray[np.intp], count: int) -> "Information":
        """Return the same as information on `count` columns, in which its own have these places."""
        inner, rows = np.zeros((count + 1, count + 1)), [*columns, count]
        inner[np.ix_(rows, rows)] = self.inner
        return Information(inner)

    def posterior(
        self,
        columns: Sequence[int] | NDArray[np.intp],
        deviations: Sequence[float] | Array | float = np.inf,
        least: float = SINGULAR,
    ) -> SizePosterior:
        """Return the posterior of the sizes of some columns with these prior deviations, (k,).

        Axes with less than the share `least` of the strongest are left out where a prior is flat.
        """
        chosen = np.asarray(columns, dtype=np.intp)
        scale = np.broadcast_to(np.asarray(deviations, dtype=np.float64), chosen.shape)
        if not len(chosen):
            return SizePosterior(np.zeros(0), np.zeros((0, 0)), 0.0)
        if np.isinf(scale).any():
            normal = self.inner[chosen[:, None], chosen] + np.diag(scale**-2.0)
            covariance, right = inverse(normal, least), self.inner[chosen, -1]
            mean = covariance @ right
            return SizePosterior(mean, covariance, 0.5 * float(mean @ right))
        factor, right = self._factored(chosen, scale), self.inner[chosen, -1] * scale
        solved = _solved(factor, right)
        covariance = _solved(factor, np.eye(len(scale))) * (scale[:, None] * scale)
        log_evidence = 0.5 * float(right @ solved) - _occam(factor)
        return SizePosterior(solved * scale, covariance, log_evidence)

    def log_evidences(self, products: Array, columns: NDArray[np.intp], deviations: Array) -> Array:
        """Return the log evidence of columns, (k,), for other residuals, (d,).

        `products`, (d, m), are those of the residuals with all columns, such as those of `drawn`.
        """
        factor, scaled = self._factored(columns, deviations), deviations * products[:, columns]
        fall = np.sum(scaled * _solved(factor, scaled.T).T, axis=1)
        return np.asarray(0.5 * fall - _occam(factor))

    def drawn(self, count: int, seed: int) -> Array:
        """Draw products of columns and residual, (count, m), of rows without any of the sizes."""
        own = self.inner[:-1, :-1]
        scale = np.sqrt(np.maximum(np.diag(own), np.finfo(np.float64).tiny))
        # The columns of a short log may depend on each other.
        correlation = own / np.outer(scale, scale) + 1e-9 * np.eye(len(scale))
        root = scale[:, None] * np.linalg.cholesky(correlation)
        return np.asarray(np.random.default_rng(seed).standard_normal((count, len(scale))) @ root.T)

    def given(
        self,
        columns: Sequence[int],
        deviations: Sequence[float] | Array | float = np.inf,
        kept: Sequence[int] | None = None,
    ) -> tuple["Information", float]:
        """Return what is left when columns are integrated out, and ln of their own evidence.

        Only the columns `kept` remain, all of them by default; the columns keep their order. A
        column that is integrated out and kept stands for a further size of its own.
        """
        size = len(self.inner)
        rows = np.arange(size) if kept is None else np.array([*kept, size - 1], dtype=np.intp)
        whole = self.inner[rows[:, None], rows]
        if not len(columns):
            return Information(whole), 0.0
        chosen = np.asarray(columns, dtype=np.intp)
        scale = np.broadcast_to(np.asarray(deviations, dtype=np.float64), chosen.shape)
        across = self.inner[chosen[:, None], rows]
        if np.isinf(scale).any():
            found = self.posterior(chosen, scale)
            return Information(whole - across.T @ found.covariance @ across), found.log_evidence
        factor, across = self._factored(chosen, scale), across * scale[:, None]
        removed = across.T @ _solved(factor, across)
        return Information(whole - removed), 0.5 * float(removed[-1, -1]) - _occam(factor)

    def marginal(self, columns: Sequence[int], deviations: Array) -> "Marginal":
        """Return what is left when some columns are integrated out, with what they take.

        All columns stay, so that one of these may be asked for as a further size.
        """
        if not len(columns):
            return Marginal(self, np.zeros((len(self.inner), 0)))
        chosen = np.asarray(columns, dtype=np.intp)
        across = self.inner[chosen] * deviations[:, None]
        taken = solve_triangular(self._factored(chosen, deviations), across, lower=True).T
        return Marginal(Information(self.inner - taken @ taken.T), taken)

    def less(self, columns: Sequence[int], sizes: Array) -> "Information":
        """Return the information of the rows less some columns of these sizes, (k,)."""
        chosen = np.asarray(columns, dtype=np.intp)
        inner, taken = self.inner.copy(), self.inner[:, chosen] @ sizes
        inner[:, -1] -= taken
        inner[-1] -= taken
        inner[-1, -1] += taken[chosen] @ sizes
        return Information(inner)

    def without(self, combination: Array, deviation: float) -> "Information":
        """Return the information with a combination's size, (m + 1,), integrated out.

        The combination has 0 for the residual. All columns stay.
        """
        across = self.inner @ combination
        share = deviation**2 / (1.0 + deviation**2 * float(combination @ across))
        return Information(self.inner - share * np.outer(across, across))

    def tempered(self, power: float) -> "Information":
        """Return the information of the likelihood to some power, as of noise 1/√power as large."""
        return Information(power * self.inner)

    def gain(self, columns: Sequence[int], given: Sequence[int] = ()) -> float:
        """Return the fall of the sum of squares by some columns beside those that are `given`."""
        both, alone = self.posterior([*given, *columns]), self.posterior(given)
        return max(0.0, 2.0 * (both.log_evidence - alone.log_evidence))

    def scores(self, columns: Sequence[int], given: Sequence[int] = ()) -> Array:
        """Return the size of each column alone over its deviation, beside the `given` ones.

        Others are `given` in the fit; 0 for one that the given ones reproduce.
        """
        left = self.given(given, kept=columns)[0].inner
        power, whole = np.diag(left)[:-1], np.diag(self.inner)[list(columns)]
        usable = power > SINGULAR * np.maximum(whole, np.finfo(np.float64).tiny)
        return np.where(usable, left[:-1, -1] / np.sqrt(np.where(usable, power, 1.0)), 0.0)

    def _factored(self, chosen: NDArray[np.intp], scale: Array) -> Array:
        """The lower Cholesky factor of I + PA, (k, k); above its diagonal stands nothing of use."""
        scaled = self.inner[chosen[:, None], chosen] * (scale[:, None] * scale)
        scaled.flat[:: len(chosen) + 1] += 1.0
        # LAPACK itself: around matrices of a few sizes SciPy's own functions take ten times as long
        # as the arithmetic.
        factor, failed = dpotrf(scaled, lower=True, clean=False)
        if failed:  # A has no negative power but by rounding
            powers, axes = np.linalg.eigh(scaled)
            factor = np.linalg.cholesky((axes * np.maximum(powers, 1.0)) @ axes.T)
        return np.asarray(factor)


@dataclass(frozen=True, slots=True)
class Marginal:
    """What is `left` when some columns are integrated out, of the likelihood to some `power`.

    `taken`, (m + 1, k), is what their k sizes take: left + taken takenᵀ are the inner products
    before.
    """

    left: Information
    taken: Array
    power: float = 1.0

    def tempered(self, power: float) -> "Marginal":
        """Return the same of the likelihood to a further power."""
        return Marginal(self.left.tempered(power), np.sqrt(power) * self.taken, power * self.power)


def information_from(normal: Array, right: Array, square: float = 0.0) -> Information:
    """Return the information of inner products: of columns (m, m), and with the residual (m,).

    `square` is that of the residual with itself.
    """
    return Information(np.block([[normal, right[:, None]], [right[None], np.array([[square]])]]))


def _solved(factor: Array, right: Array) -> Array:
    return np.asarray(dpotrs(factor, right, lower=True)[0])


def _occam(factor: Array) -> float:
    """The logarithm of the Occam factor: half that of the determinant of I + PA."""
    return float(np.sum(np.log(factor.diagonal())))
