"""The model structures of Martos, Kiszely and Foster (2011, Fig 4): each a basis in x = q_ci/q_ref.

The source shows Inverse+ only as a figure; k1 + k2 x + k3/x is our reading of it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pitotbench.units import Array

Term = Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class TermModel:
    """A model of Δp/q_c that is linear in its parameters: one term and its slope a parameter."""

    name: str
    parameter_names: tuple[str, ...]
    terms: tuple[tuple[Term, Term], ...]
    formula: str

    def basis(self, x: Array) -> Array:
        """The terms at x = q_ci/q_ref, shape (n,): an array of shape (n, k), dimensionless."""
        return np.stack([term(x) for term, _ in self.terms], axis=-1)

    def basis_slope(self, x: Array) -> Array:
        """The derivatives of the terms with respect to x, shape (n, k)."""
        return np.stack([slope(x) for _, slope in self.terms], axis=-1)

    def spread_over(self, low: float, high: float) -> "TermModel":
        """The model itself: a law has no knots."""
        return self


ONE: tuple[Term, Term] = (np.ones_like, np.zeros_like)
X: tuple[Term, Term] = (lambda x: x, np.ones_like)
X_SQUARED: tuple[Term, Term] = (lambda x: x * x, lambda x: 2.0 * x)
ONE_OVER_X: tuple[Term, Term] = (lambda x: 1.0 / x, lambda x: -1.0 / (x * x))

BIAS = TermModel("bias", ("k1",), (ONE,), "k1")
LINEAR = TermModel("linear", ("k1", "k2"), (ONE, X), "k1 + k2 x")
QUADRATIC = TermModel("quadratic", ("k1", "k2", "k3"), (ONE, X, X_SQUARED), "k1 + k2 x + k3 x²")
INVERSE = TermModel("inverse", ("k1", "k2"), (ONE, ONE_OVER_X), "k1 + k2/x")
INVERSE_PLUS = TermModel("inverse+", ("k1", "k2", "k3"), (ONE, X, ONE_OVER_X), "k1 + k2 x + k3/x")
