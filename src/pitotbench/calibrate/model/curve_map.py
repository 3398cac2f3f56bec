"""The error curve over indicated airspeed from fitted parameters, with its derivatives."""

from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.units import KNOT, Array, Meters, MetersPerSecond, Pascal

_STEPS_KT = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
_MOST_POINTS = 32
_SLACK_KT = 1.5  # a round airspeed this far outside the data still counts as covered


@dataclass(frozen=True, slots=True)
class CurveMap:
    """The curve and its gradients as functions of the error parameters k (K,), at fixed indicated airspeeds (c,).

    `indicated_airspeed` [m/s] is the raw reading. `zero` [Pa] is the zero offset of the impact pressure in it; q_ci
    is the reading minus the offset.
    """

    model: PredictionModel
    indicated_airspeed: MetersPerSecond
    zero: float = 0.0

    def impact_pressure(self) -> Pascal:
        """q_ci at the curve's airspeeds [Pa], (c,): the pressure at the ports, without the sensor's zero offset."""
        return air.impact_pressure(self.indicated_airspeed) - self.zero

    def basis(self) -> Array:
        """The error model's basis at the curve's airspeeds, (c, K) [-]."""
        return self.model.error.basis(self.impact_pressure() / self.model.reference_pressure)

    def normalized(self, k: Array) -> Array:
        """Normalized pressure error Δp/q_c, (c,) [-]."""
        return np.asarray(self.basis() @ k)

    def correction(self, k: Array) -> MetersPerSecond:
        """Calibrated airspeed minus the raw reading [m/s], (c,)."""
        pressure = self.impact_pressure() / (1.0 - self.normalized(k))
        return air.calibrated_airspeed(pressure) - self.indicated_airspeed

    def correction_gradient(self, k: Array) -> Array:
        """Derivative of the correction with respect to k, (c, K) [m/s]."""
        rest = 1.0 - self.normalized(k)
        pressure = self.impact_pressure() / rest
        return self.basis() * (air.calibrated_airspeed_slope(pressure) * pressure / rest)[:, None]

    def correction_by_zero(self, k: Array) -> Array:
        """Derivative of the correction with respect to the zero offset, (c,) [m/s per Pa]."""
        rest, reference = 1.0 - self.normalized(k), self.model.reference_pressure
        bend = self.model.error.basis_slope(self.impact_pressure() / reference) @ k / reference
        by_indicated = (1.0 + self.impact_pressure() * bend / rest) / rest
        return np.asarray(-air.calibrated_airspeed_slope(self.impact_pressure() / rest) * by_indicated)

    def altitude(self, k: Array, static_pressure: float) -> Meters:
        """True minus indicated pressure altitude [m], (c,), for an error of the static source.

        `static_pressure` [Pa] is the indicated one. The true one is p = p_i − Δp; a lower pressure is a greater
        altitude.
        """
        error = self.impact_pressure() * (1.0 / (1.0 - self.normalized(k)) - 1.0)
        return air.pressure_altitude(static_pressure - error) - air.pressure_altitude(static_pressure)

    def altitude_gradient(self, k: Array, static_pressure: float) -> Array:
        """Derivative of the altitude correction with respect to k, (c, K) [m]."""
        rest = 1.0 - self.normalized(k)
        pressure = self.impact_pressure()
        true = static_pressure - pressure * (1.0 / rest - 1.0)
        temperature = air.standard_temperature(air.pressure_altitude(true))
        meters_a_pascal = air.GAS_CONSTANT * temperature / (true * air.GRAVITY)
        return np.asarray(self.basis() * (meters_a_pascal * pressure / rest**2)[:, None])


def curve_airspeeds(indicated_airspeed: MetersPerSecond) -> MetersPerSecond:
    """Round indicated airspeeds [m/s], (c,), over the range of the data (n,) between its 0.1 and 99.9 percentiles.

    They are multiples of the least step in knots that gives 32 points or fewer.
    """
    low, high = np.quantile(indicated_airspeed, [0.001, 0.999]) / KNOT
    for step in _STEPS_KT:
        first = np.ceil((low - _SLACK_KT) / step) * step
        points = np.arange(first, high + _SLACK_KT, step)
        if len(points) <= _MOST_POINTS:
            break
    if len(points) < 2:
        points = np.array([low, high])
    return np.asarray(points * KNOT)
