"""A pressure error given as a table over indicated airspeed, linear between points, held at the ends."""

from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.pressure_error.curve import invert
from pitotbench.units import Array, Pascal


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
