"""The predicted air data for a given ground velocity, wind and error curve, with the exact Jacobian.

The noisy channel (indicated impact pressure) is predicted from the clean one (ground velocity). The parameters are
θ = [k1 … kK, W_N, W_E (, W_D)], wind components in m/s toward north, east and down.
"""

from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.pressure_error import PressureErrorModel
from pitotbench.units import Array, Kelvin, MetersPerSecond, Pascal

_NEWTON_STEPS = 8  # more are needed only where the error curve bends back on itself
_BLOCK = 1 << 12  # rows: their arrays fill a part of a processor's cache
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
        """The number of parameters of the error curve, K."""
        return len(self.error.parameter_names)

    @property
    def count(self) -> int:
        """The number of parameters in all: those of the curve and the components of the wind."""
        return self.error_count + (3 if self.wind_down else 2)

    def predict(self, theta: Array, obs: Observations) -> Prediction:
        """Predict every row for θ (p,)."""
        work = _Work(self, theta, obs)
        # Block by block, so that a block's arrays stay in the processor's cache: a long log takes half the time.
        # All blocks take the same number of Newton steps, so the numbers do not depend on the size of a block.
        blocks = [slice(first, first + _BLOCK) for first in range(0, len(obs), _BLOCK)]
        for rows in blocks:
            work.place(rows)
        for _ in range(_NEWTON_STEPS):
            step = np.max([work.improve(rows) for rows in blocks])
            if float(step) < _LAST_STEP * float(np.max(work.indicated)):
                break  # convergence is quadratic: the remaining error is far below the step
        for rows in blocks:
            work.differentiate(rows)
        return Prediction(
            work.indicated, work.jacobian, work.impact, work.speed, work.slope, error_count=self.error_count
        )


class _Work:
    """The arrays of a prediction, (n,) each, filled for some rows at a time."""

    def __init__(self, model: PredictionModel, theta: Array, obs: Observations) -> None:
        count = len(obs)
        self._model, self._obs = model, obs
        self._k, self._wind = theta[: model.error_count], theta[model.error_count :]
        self.indicated = obs.impact_pressure.copy()  # Newton's method starts from the measured one
        self.jacobian = np.empty((model.count, count)).T  # contiguous columns
        self.impact, self.speed, self.slope = np.empty(count), np.empty(count), np.empty(count)
        self._ratio, self._ratio_slope, self._by_ratio = np.empty(count), np.empty(count), np.empty(count)

    def place(self, rows: slice) -> None:
        """Find the impact pressure of the ground velocity less the wind, as a share of the static pressure."""
        obs = self._obs
        north, east, down = self._through_air(rows)
        self._ratio[rows], self._ratio_slope[rows], self.speed[rows] = _pressure_ratio(
            north, east, down, obs.probe_temperature[rows], obs.probe_heating
        )
        self.impact[rows] = obs.static_pressure[rows] * self._ratio[rows]

    def _through_air(self, rows: slice) -> tuple[Array, Array, Array]:
        obs, wind = self._obs, self._wind
        down = obs.velocity_down[rows]
        down = down - wind[2] if self._model.wind_down else down
        return obs.velocity_north[rows] - wind[0], obs.velocity_east[rows] - wind[1], down

    def improve(self, rows: slice) -> float:
        """Take one Newton step to the solution of q_ci = F(f(q_ci/q_ref)), and return the largest step [Pa]."""
        model, ratio, impact, q = self._model, self._ratio[rows], self.impact[rows], self.indicated[rows]
        x = q / model.reference_pressure
        basis, f_slope = model.error.basis(x), model.error.basis_slope(x) @ self._k
        f = basis @ self._k
        shape = 1.0 / (1.0 + f * ratio) if model.static_error else 1.0
        value = impact * (1.0 - f) * shape
        by_f = -impact * (1.0 + ratio) * shape**2 if model.static_error else -impact
        damping = 1.0 - by_f * f_slope / model.reference_pressure
        step = (value - q) / damping
        q += step
        by_ratio = self._obs.static_pressure[rows] * (1.0 - f) * (shape**2 if model.static_error else 1.0)
        self._by_ratio[rows] = by_ratio / damping
        self.jacobian[rows, : model.error_count] = basis * (by_f / damping)[:, None]
        return float(np.max(np.abs(step)))

    def differentiate(self, rows: slice) -> None:
        """Fill the derivatives by the wind and by the true airspeed."""
        by_speed_squared = self._by_ratio[rows] * self._ratio_slope[rows]
        for column, axis in enumerate(self._through_air(rows)[: len(self._wind)], start=self._model.error_count):
            self.jacobian[rows, column] = by_speed_squared * (-2.0 * axis)
        self.slope[rows] = 2.0 * self.speed[rows] * by_speed_squared


def _pressure_ratio(
    north: Array, east: Array, down: Array, probe_temperature: Kelvin, probe_heating: float
) -> tuple[Array, Array, Array]:
    """q_c/p of an air velocity, its derivative with respect to V², and V [m/s].

    From V² = M² γRT and T_t = T(1 + 0.2 r M²): M² = V²/(γR T_t − 0.2 r V²).
    """
    squared = north * north + east * east + down * down
    heat = air.HEAT_RATIO * air.GAS_CONSTANT * probe_temperature
    rest = heat - probe_heating * squared
    mach_squared = squared / rest
    base = 1.0 + 0.2 * mach_squared
    power = base * base * np.sqrt(base)
    return power * base - 1.0, 0.7 * power * heat / (rest * rest), np.sqrt(squared)
