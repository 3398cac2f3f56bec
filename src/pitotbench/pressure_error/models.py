"""The models of Martos, Kiszely and Foster (2011, Fig 4), each a sum of terms in x = q_ci/q_ref.

The source shows Inverse+ only as a figure; k1 + k2 x + k3/x is our reading of it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.units import Array

Term = Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class TermModel:
    """A model of Δp/q_c that is linear in its parameters. `terms` holds a term and its slope for each parameter."""

    name: str
    parameter_names: tuple[str, ...]
    terms: tuple[tuple[Term, Term], ...]
    formula: str

    def basis(self, x: Array) -> Array:
        """Return the terms at x = q_ci/q_ref, (n,), as an array (n, k) [-]."""
        return _columns([term for term, _ in self.terms], x)

    def basis_slope(self, x: Array) -> Array:
        """Return the derivatives of the terms with respect to x, (n, k)."""
        return _columns([slope for _, slope in self.terms], x)

    def spread_over(self, low: float, high: float) -> "TermModel":
        """Return the model itself: a formula has no knots."""
        return self


def _columns(terms: Sequence[Term], x: Array) -> Array:
    """Return the terms as columns, (n, k)."""
    # Each column is contiguous in memory, because fits work column by column.
    rows = np.empty((len(terms), *np.shape(x)))
    for row, term in zip(rows, terms, strict=True):
        row[...] = term(x)
    return np.moveaxis(rows, 0, -1)


ONE: tuple[Term, Term] = (np.ones_like, np.zeros_like)
X: tuple[Term, Term] = (lambda x: x, np.ones_like)
X_SQUARED: tuple[Term, Term] = (lambda x: x * x, lambda x: 2.0 * x)
ONE_OVER_X: tuple[Term, Term] = (lambda x: 1.0 / x, lambda x: -1.0 / (x * x))

BIAS = TermModel("bias", ("k1",), (ONE,), "k1")
LINEAR = TermModel("linear", ("k1", "k2"), (ONE, X), "k1 + k2 x")
QUADRATIC = TermModel("quadratic", ("k1", "k2", "k3"), (ONE, X, X_SQUARED), "k1 + k2 x + k3 x²")
INVERSE = TermModel("inverse", ("k1", "k2"), (ONE, ONE_OVER_X), "k1 + k2/x")
INVERSE_PLUS = TermModel("inverse+", ("k1", "k2", "k3"), (ONE, X, ONE_OVER_X), "k1 + k2 x + k3/x")
