"""A pressure error with numbers in it: from indicated to true impact pressure and back."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pitotbench.pressure_error.model import PressureErrorModel
from pitotbench.units import Array, Pascal

_ITERATIONS = 60
_TOLERANCE = 1e-12


class PressureErrorRangeError(ValueError):
    """The pressure error cannot be applied where it was asked for: the message says where and why."""


@dataclass(frozen=True, slots=True)
class PressureErrorCurve:
    """Δp/q_c = f(q_ci/q_ref) with parameters; Δp = q_c − q_ci (the sign of Martos et al. 2011)."""

    model: PressureErrorModel
    parameters: tuple[float, ...]
    reference_pressure: float

    def __post_init__(self) -> None:
        if len(self.parameters) != len(self.model.parameter_names):
            wanted = ", ".join(self.model.parameter_names)
            raise ValueError(f"model {self.model.name!r} takes the parameters {wanted}, got {self.parameters}")

    def normalized(self, indicated_impact_pressure: Pascal) -> Array:
        """Δp/q_c [-] at an indicated impact pressure [Pa]."""
        x = np.asarray(indicated_impact_pressure, dtype=np.float64) / self.reference_pressure
        return np.asarray(self.model.basis(x) @ np.asarray(self.parameters))

    def impact_pressure(self, indicated_impact_pressure: Pascal) -> Pascal:
        """True impact pressure [Pa], q_c = q_ci/(1 − f)."""
        q_ci = np.asarray(indicated_impact_pressure, dtype=np.float64)
        return q_ci / (1.0 - self.normalized(q_ci))

    def indicated_impact_pressure(self, impact_pressure: Pascal) -> Pascal:
        """Indicated impact pressure [Pa] of a true one [Pa]: solves q_ci = q_c (1 − f(q_ci)).

        Raises PressureErrorRangeError where no solution is found (f close to or above 1).
        """
        return invert(self.normalized, impact_pressure)


def invert(normalized: Callable[[Array], Array], impact_pressure: Pascal) -> Pascal:
    """Solve q_ci = q_c (1 − f(q_ci)) by the secant method, each sample for itself."""
    q_c = np.asarray(impact_pressure, dtype=np.float64)
    old = q_c.copy()
    gap_old = q_c * (1.0 - normalized(old)) - old
    new = old + gap_old
    for _ in range(_ITERATIONS):
        gap = q_c * (1.0 - normalized(new)) - new
        if not np.all(np.isfinite(gap)) or np.any(new <= 0.0):
            break
        if np.all(np.abs(gap) <= _TOLERANCE * q_c):
            return new
        step = new - old
        slope = np.divide(gap - gap_old, step, out=np.full_like(step, -1.0), where=np.abs(step) > 1e-9 * q_c)
        old, gap_old = new, gap
        new = new - gap / np.where(np.abs(slope) < 0.1, -1.0, slope)
    low, high = float(np.min(q_c)), float(np.max(q_c))
    raise PressureErrorRangeError(
        f"the pressure error has no indicated impact pressure for q_c between {low:.0f} and {high:.0f} Pa; "
        "it must stay well below 1 and vary slowly there: check its parameters and reference pressure"
    )
