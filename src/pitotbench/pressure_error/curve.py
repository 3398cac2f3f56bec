"""A pressure-error curve, with parameters or as a table: from indicated to true impact pressure and back."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.pressure_error.models import PressureErrorModel
from pitotbench.units import Array, Pascal

# A pressure-error curve with its parameters: from indicated to true impact pressure and back.

_ITERATIONS = 60

_TOLERANCE = 1e-12


class PressureErrorRangeError(ValueError):
    """The pressure error has no solution at an impact pressure. The message says where and why."""


@dataclass(frozen=True, slots=True)
class PressureErrorCurve:
    """A pressure-error curve Δp/q_c = f(q_ci/q_ref); Δp = q_c − q_ci, the sign of Martos et al. (2011).

    `reference_pressure` is q_ref [Pa]. Raises ValueError where the number of parameters does not fit the model.
    """

    model: PressureErrorModel
    parameters: tuple[float, ...]
    reference_pressure: float

    def __post_init__(self) -> None:
        if len(self.parameters) != len(self.model.parameter_names):
            wanted = ", ".join(self.model.parameter_names)
            raise ValueError(f"model {self.model.name!r} takes the parameters {wanted}, got {self.parameters}")

    def normalized(self, indicated_impact_pressure: Pascal) -> Array:
        """Return Δp/q_c [-] at an indicated impact pressure [Pa], any shape."""
        x = np.asarray(indicated_impact_pressure, dtype=np.float64) / self.reference_pressure
        return np.asarray(self.model.basis(x) @ np.asarray(self.parameters))

    def impact_pressure(self, indicated_impact_pressure: Pascal) -> Pascal:
        """Return the true impact pressure q_c = q_ci/(1 − f) of an indicated one [Pa], any shape."""
        q_ci = np.asarray(indicated_impact_pressure, dtype=np.float64)
        return q_ci / (1.0 - self.normalized(q_ci))

    def indicated_impact_pressure(self, impact_pressure: Pascal) -> Pascal:
        """Return the indicated impact pressure of a true one [Pa], (n,): solve q_ci = q_c (1 − f(q_ci)).

        Raises PressureErrorRangeError where no solution is found, because f is close to 1 or above.
        """
        return invert(self.normalized, impact_pressure)


def invert(normalized: Callable[[Array], Array], impact_pressure: Pascal) -> Pascal:
    """Solve q_ci = q_c (1 − f(q_ci)) for q_ci [Pa], (n,), by the secant method, each sample separately.

    `normalized` is f as a function of q_ci [Pa]. Raises PressureErrorRangeError where no solution is found.
    """
    q_c = np.asarray(impact_pressure, dtype=np.float64)
    # Two starting points for the secant: no error, and one step of the fixed-point iteration from there.
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
        # Without a usable slope (a step near zero, a flat difference) take −1, which is right for small f.
        slope = np.divide(gap - gap_old, step, out=np.full_like(step, -1.0), where=np.abs(step) > 1e-9 * q_c)
        old, gap_old = new, gap
        new = new - gap / np.where(np.abs(slope) < 0.1, -1.0, slope)
    low, high = float(np.min(q_c)), float(np.max(q_c))
    raise PressureErrorRangeError(
        f"the pressure error has no indicated impact pressure for q_c between {low:.0f} and {high:.0f} Pa; "
        "it must stay well below 1 and vary slowly there: check its parameters and reference pressure"
    )


# A pressure error given as a table over indicated airspeed, linear between points, held at the ends.


@dataclass(frozen=True, slots=True)
class TableCurve:
    """Δp/q_c [-] over indicated airspeed [m/s], at two or more increasing airspeeds.

    Raises ValueError for fewer points, or airspeeds that do not increase.
    """

    airspeed: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.airspeed) < 2 or len(self.airspeed) != len(self.values):
            raise ValueError("a pressure-error table needs at least two airspeeds, and one value for each")
        if not np.all(np.diff(self.airspeed) > 0.0):
            raise ValueError("the airspeeds of a pressure-error table must increase")

    def normalized(self, indicated_impact_pressure: Pascal) -> Array:
        """Return Δp/q_c [-] at an indicated impact pressure [Pa], any shape."""
        speed = air.calibrated_airspeed(indicated_impact_pressure)
        return np.interp(speed, self.airspeed, self.values)

    def impact_pressure(self, indicated_impact_pressure: Pascal) -> Pascal:
        """Return the true impact pressure q_c = q_ci/(1 − f) of an indicated one [Pa], any shape."""
        q_ci = np.asarray(indicated_impact_pressure, dtype=np.float64)
        return q_ci / (1.0 - self.normalized(q_ci))

    def indicated_impact_pressure(self, impact_pressure: Pascal) -> Pascal:
        """Return the indicated impact pressure of a true one [Pa], (n,). Raises PressureErrorRangeError."""
        return invert(self.normalized, impact_pressure)
