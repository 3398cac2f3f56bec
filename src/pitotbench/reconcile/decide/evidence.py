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
from scipy.linalg import cho_factor, cho_solve

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
        chosen, scale = list(columns), np.asarray(deviations, dtype=np.float64)
        if not chosen:
            return SizePosterior(np.zeros(0), np.zeros((0, 0)), 0.0)
        scaled = self.inner[np.ix_(chosen, chosen)] * np.outer(scale, scale)
        scaled[np.diag_indices_from(scaled)] += 1.0
        right = self.inner[chosen, -1] * scale
        factor = cho_factor(scaled, lower=True)
        solved = cho_solve(factor, right)
        log_evidence = 0.5 * float(right @ solved) - float(np.sum(np.log(np.diag(factor[0]))))
        covariance = cho_solve(factor, np.eye(len(chosen))) * np.outer(scale, scale)
        return SizePosterior(solved * scale, covariance, log_evidence)

    def given(
        self, columns: Sequence[int], deviations: Sequence[float] | Array, kept: Sequence[int] | None = None
    ) -> tuple["Evidence", float]:
        """Return the evidence with some columns eliminated, and the logarithm of their own evidence.

        Only the columns `kept` remain, all of them by default; the columns keep their order.
        """
        size = len(self.inner)
        rows = list(range(size)) if kept is None else [*kept, size - 1]
        whole = self.inner[np.ix_(rows, rows)]
        chosen, scale = list(columns), np.asarray(deviations, dtype=np.float64)
        if not chosen:
            return Evidence(whole), 0.0
        scaled = self.inner[np.ix_(chosen, chosen)] * np.outer(scale, scale)
        scaled[np.diag_indices_from(scaled)] += 1.0
        across = self.inner[np.ix_(chosen, rows)] * scale[:, None]
        factor = cho_factor(scaled, lower=True)
        removed = across.T @ cho_solve(factor, across)
        log_evidence = 0.5 * float(removed[-1, -1]) - float(np.sum(np.log(np.diag(factor[0]))))
        return Evidence(whole - removed), log_evidence

    def tempered(self, power: float) -> "Evidence":
        """Return the evidence of the likelihood to some power: that of noise 1/√power times as large."""
        return Evidence(power * self.inner)

    def __add__(self, other: "Evidence") -> "Evidence":
        """Return the evidence of two logs with the same columns and the same sizes: the inner products add up."""
        return Evidence(self.inner + other.inner)
