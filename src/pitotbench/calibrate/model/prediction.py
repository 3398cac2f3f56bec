"""The predicted air data for a given ground velocity, wind and error curve, with the exact Jacobian.

The noisy channel (indicated impact pressure) is predicted from the clean one (ground velocity). The parameters are
θ = [k1 … kK, W_N, W_E (, W_D)], wind components in m/s toward north, east and down.
"""

from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.pressure_error import PressureErrorModel
from pitotbench.units import Array, MetersPerSecond, Pascal

_NEWTON_STEPS = 8  # more are needed only where the error curve bends back on itself
_LAST_STEP = 1e-5  # of the impact pressure; the remaining error is about 1e-10 of it


@dataclass(frozen=True, slots=True)
class Prediction:
    """The prediction for n rows.

    `indicated` (n,) [Pa] is the indicated impact pressure and `jacobian` (n, p) its derivative with respect to θ;
    `impact_pressure` (n,) [Pa] is the true one and `true_airspeed` (n,) [m/s] the predicted one. `slope` (n,)
    [Pa s/m] is the derivative of the indicated impact pressure with respect to true airspeed.
    """

    indicated: Pascal
    jacobian: Array
    impact_pressure: Pascal
    true_airspeed: MetersPerSecond
    slope: Array
    error_count: int

    @property
    def wind_columns(self) -> Array:
        """The part of the Jacobian that belongs to the wind, (n, 2 or 3) [Pa s/m]."""
        return self.jacobian[:, self.error_count :]


@dataclass(frozen=True, slots=True)
class PredictionModel:
    """The prediction to be fitted.

    `reference_pressure` [Pa] is q_ref of the error model. With `static_error` the error is that of the static
    source and changes the static pressure too. With `wind_down` the vertical wind is a parameter.
    """

    error: PressureErrorModel
    reference_pressure: float
    static_error: bool = False
    wind_down: bool = False

    @property
    def error_count(self) -> int:
        return len(self.error.parameter_names)

    @property
    def count(self) -> int:
        return self.error_count + (3 if self.wind_down else 2)

    def predict(self, theta: Array, obs: Observations) -> Prediction:
        """Predict every row for θ (p,)."""
        k, wind = theta[: self.error_count], theta[self.error_count :]
        north, east, down = obs.velocity_north - wind[0], obs.velocity_east - wind[1], obs.velocity_down
        down = down - wind[2] if self.wind_down else down
        ratio, ratio_slope, speed = _pressure_ratio(north, east, down, obs)
        indicated, by_error, by_ratio, basis = self._indicated(k, ratio, obs)
        by_speed_squared = by_ratio * ratio_slope
        along = [-2.0 * north, -2.0 * east] + ([-2.0 * down] if self.wind_down else [])
        jacobian = np.empty((self.count, len(obs))).T  # contiguous columns
        jacobian[:, : self.error_count] = basis * by_error[:, None]
        for column, axis in enumerate(along, start=self.error_count):
            jacobian[:, column] = by_speed_squared * axis
        impact = obs.static_pressure * ratio
        return Prediction(indicated, jacobian, impact, speed, 2.0 * speed * by_speed_squared, self.error_count)

    def _indicated(self, k: Array, ratio: Array, obs: Observations) -> tuple[Array, Array, Array, Array]:
        """Solve q_ci = F(f(q_ci/q_ref)) by Newton, from the measured q_ci; also dq_ci/df, dq_ci/d(q_c/p) and the
        basis."""
        impact = obs.static_pressure * ratio
        q = obs.impact_pressure
        for _ in range(_NEWTON_STEPS):
            x = q / self.reference_pressure
            basis, f_slope = self.error.basis(x), self.error.basis_slope(x) @ k
            f = basis @ k
            shape = 1.0 / (1.0 + f * ratio) if self.static_error else 1.0
            value = impact * (1.0 - f) * shape
            by_f = -impact * (1.0 + ratio) * shape**2 if self.static_error else -impact
            damping = 1.0 - by_f * f_slope / self.reference_pressure
            step = (value - q) / damping
            q = q + step
            if float(np.max(np.abs(step))) < _LAST_STEP * float(np.max(q)):
                break  # convergence is quadratic: the remaining error is far below the step
        by_ratio = obs.static_pressure * (1.0 - f) * (shape**2 if self.static_error else 1.0)
        return q, by_f / damping, by_ratio / damping, basis


def _pressure_ratio(north: Array, east: Array, down: Array, obs: Observations) -> tuple[Array, Array, Array]:
    """q_c/p of an air velocity, its derivative with respect to V², and V [m/s].

    From V² = M² γRT and T_t = T(1 + 0.2 r M²): M² = V²/(γR T_t − 0.2 r V²).
    """
    squared = north * north + east * east + down * down
    heat = air.HEAT_RATIO * air.GAS_CONSTANT * obs.probe_temperature
    rest = heat - obs.probe_heating * squared
    mach_squared = squared / rest
    base = 1.0 + 0.2 * mach_squared
    power = base * base * np.sqrt(base)
    return power * base - 1.0, 0.7 * power * heat / (rest * rest), np.sqrt(squared)
