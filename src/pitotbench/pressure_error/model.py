"""The interface of a pressure-error model, for the calibrator and the simulated sensors."""

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
        """The names of the parameters, in the order of the terms."""
        ...

    @property
    def formula(self) -> str:
        """The model in words or symbols, with the name of every parameter."""
        ...

    def basis(self, x: Array) -> Array:
        """Return the terms at x, (n,), as an array (n, k) [-], k being the number of parameters."""
        ...

    def basis_slope(self, x: Array) -> Array:
        """Return the derivatives of the terms with respect to x, (n, k)."""
        ...

    def spread_over(self, low: float, high: float) -> "PressureErrorModel":
        """Return the model for data between x = low and x = high. Knots, if there are any, lie in that range."""
        ...
