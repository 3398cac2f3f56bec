"""The model structures of Martos, Kiszely and Foster (2011, Fig 4): each a basis in x = q_ci/q_ref.

The source shows Inverse+ only as a figure; k1 + k2 x + k3/x is our reading of it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class PressureErrorModel:
    """A model of Δp/q_c that is linear in its parameters: `basis(x)` has shape (n, number of parameters)."""

    name: str
    parameter_names: tuple[str, ...]
    terms: tuple[Callable[[Array], Array], ...]
    formula: str

    def basis(self, x: Array) -> Array:
        """The terms at x = q_ci/q_ref, shape (n,): an array of shape (n, k), dimensionless."""
        return np.stack([term(x) for term in self.terms], axis=-1)


def _one(x: Array) -> Array:
    return np.ones_like(x)


def _x(x: Array) -> Array:
    return x


def _x_squared(x: Array) -> Array:
    return x * x


def _one_over_x(x: Array) -> Array:
    return 1.0 / x


BIAS = PressureErrorModel("bias", ("k1",), (_one,), "k1")
LINEAR = PressureErrorModel("linear", ("k1", "k2"), (_one, _x), "k1 + k2 x")
QUADRATIC = PressureErrorModel("quadratic", ("k1", "k2", "k3"), (_one, _x, _x_squared), "k1 + k2 x + k3 x²")
INVERSE = PressureErrorModel("inverse", ("k1", "k2"), (_one, _one_over_x), "k1 + k2/x")
INVERSE_PLUS = PressureErrorModel("inverse+", ("k1", "k2", "k3"), (_one, _x, _one_over_x), "k1 + k2 x + k3/x")
