"""What a pressure-error model is to those who fit it or fly with it."""

from typing import Protocol

from pitotbench.units import Array


class PressureErrorModel(Protocol):
    """A model of Δp/q_c over x = q_ci/q_ref that is linear in its parameters."""

    @property
    def name(self) -> str:
        """The model's name in the table."""
        ...

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """One name a parameter."""
        ...

    @property
    def formula(self) -> str:
        """The model in words or symbols; holds every parameter's name."""
        ...

    def basis(self, x: Array) -> Array:
        """The terms at x, shape (n,): an array of shape (n, k), dimensionless."""
        ...

    def basis_slope(self, x: Array) -> Array:
        """The derivatives of the terms with respect to x, shape (n, k)."""
        ...

    def spread_over(self, low: float, high: float) -> "PressureErrorModel":
        """The model for data between x = low and high: its knots lie there if it has any."""
        ...
