"""The evidence for linear Gaussian models: how probable a log is when some columns have sizes with priors.

A log is a vector r = X s + noise with white noise of variance 1 and sizes s of prior N(0, P). With A = XᵀX and
b = Xᵀr, its probability relative to that without the columns is

    ln Z = ½ bᵀ (P⁻¹ + A)⁻¹ b − ½ ln det(I + P A),

the gain of a ridge regression less an Occam factor (MacKay, Information Theory, Inference, and Learning Algorithms,
2003, ch. 28; Rasmussen and Williams 2006, §2.7). Columns that every model shares are eliminated first.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotrs

from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class SizePosterior:
    """The posterior of some sizes: mean, (k,), covariance, (k, k), and the logarithm of the evidence."""

    mean: Array
    covariance: Array
    log_evidence: float


@dataclass(frozen=True, slots=True)
class Evidence:
    """The inner products of a log, (m + 1, m + 1): columns in units of the noise, and the residual last."""

    inner: Array

    def of(self, columns: Sequence[int], deviations: Sequence[float] | Array) -> SizePosterior:
        """Return the posterior of the sizes of some columns with these prior deviations, (k,)."""
        if not len(columns):
            return SizePosterior(np.zeros(0), np.zeros((0, 0)), 0.0)
        factor, right, scale = self._factored(columns, deviations)
        solved = _solved(factor, right)
        covariance = _solved(factor, np.eye(len(scale))) * (scale[:, None] * scale)
        return SizePosterior(solved * scale, covariance, _log_evidence(factor, float(right @ solved)))

    def log_evidence_of(self, columns: Sequence[int], deviations: Sequence[float] | Array) -> float:
        """Return the logarithm of the evidence for some columns with these prior deviations, (k,).

        It spares the covariance of the sizes, which costs most where the columns are many.
        """
        if not len(columns):
            return 0.0
        factor, right, _ = self._factored(columns, deviations)
        return _log_evidence(factor, float(right @ _solved(factor, right)))

    def _factored(self, columns: Sequence[int], deviations: Sequence[float] | Array) -> tuple[Array, Array, Array]:
        """The Cholesky factor of I + PA, b in units of the deviations, and these deviations."""
        chosen, scale = np.asarray(columns, dtype=np.intp), np.asarray(deviations, dtype=np.float64)
        scaled = self.inner[chosen[:, None], chosen] * (scale[:, None] * scale)
        scaled.flat[:: len(chosen) + 1] += 1.0
        return _factor(scaled), self.inner[chosen, -1] * scale, scale

    def given(
        self, columns: Sequence[int], deviations: Sequence[float] | Array, kept: Sequence[int] | None = None
    ) -> tuple["Evidence", float]:
        """Return the evidence with some columns eliminated, and the logarithm of their own evidence.

        Only the columns `kept` remain, all of them by default; the columns keep their order.
        """
        size = len(self.inner)
        rows = np.arange(size) if kept is None else np.array([*kept, size - 1], dtype=np.intp)
        whole = self.inner[rows[:, None], rows]
        if not len(columns):
            return Evidence(whole), 0.0
        factor, _, scale = self._factored(columns, deviations)
        across = self.inner[np.asarray(columns, dtype=np.intp)[:, None], rows] * scale[:, None]
        removed = across.T @ _solved(factor, across)
        return Evidence(whole - removed), _log_evidence(factor, float(removed[-1, -1]))

    def tempered(self, power: float) -> "Evidence":
        """Return the evidence of the likelihood to some power: that of noise 1/√power times as large."""
        return Evidence(power * self.inner)

    def __add__(self, other: "Evidence") -> "Evidence":
        """Return the evidence of two logs with the same columns and the same sizes: the inner products add up."""
        return Evidence(self.inner + other.inner)


# LAPACK itself: around matrices of a few sizes SciPy's own functions take ten times as long as the arithmetic.
def _factor(matrix: Array) -> Array:
    """The lower Cholesky factor, (k, k); what stands above its diagonal is of no use."""
    factor, failed = dpotrf(matrix, lower=True, clean=False)
    if failed:
        raise np.linalg.LinAlgError("the inner products of a log are not positive definite")
    return np.asarray(factor)


def _solved(factor: Array, right: Array) -> Array:
    return np.asarray(dpotrs(factor, right, lower=True)[0])


def _log_evidence(factor: Array, fall: float) -> float:
    """The logarithm of the evidence by the fall of the sum of squares."""
    return 0.5 * fall - float(np.sum(np.log(factor.diagonal())))
