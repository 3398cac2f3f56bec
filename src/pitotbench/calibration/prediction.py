"""The air data predicted by ground velocity, wind and error curve, with an exact Jacobian."""

from dataclasses import dataclass, replace

import numpy as np

from pitotbench import air
from pitotbench.calibration.observations import Observations
from pitotbench.estimation.mixture import Posterior
from pitotbench.pressure_error.models import PressureErrorModel
from pitotbench.records.log import CurveMove
from pitotbench.units import KNOT, Array, Kelvin, Meters, MetersPerSecond, Pascal

_NEWTON_STEPS = 8  # more are needed only where the error curve bends back on itself
_BLOCK = 1 << 12  # rows: their arrays fill a part of a processor's cache
_LAST_STEP = 1e-5  # of the impact pressure; the remaining error is about 1e-10 of it


@dataclass(frozen=True, slots=True)
class Prediction:
    """The prediction for n rows.

    `indicated` (n,) [Pa] is the indicated impact pressure and `jacobian` (n, p) its derivative with
    respect to θ; `impact_pressure` (n,) [Pa] is the true one and `true_airspeed` (n,) [m/s] the
    predicted one. `slope` (n,) [Pa s/m] is the derivative of the indicated impact pressure with
    respect to true airspeed, `by_error` (n,) [Pa] that with respect to the normalized pressure
    error.
    """

    indicated: Pascal
    jacobian: Array
    impact_pressure: Pascal
    true_airspeed: MetersPerSecond
    slope: Array
    by_error: Pascal
    error_count: int

    @property
    def wind_columns(self) -> Array:
        """The part of the Jacobian that belongs to the wind, (n, 2 or 3) [Pa s/m]."""
        return self.jacobian[:, self.error_count :]

    def without_curve(self) -> "Prediction":
        """Return the prediction without the curve's part of the Jacobian, most of its memory."""
        return replace(self, jacobian=self.wind_columns.copy(order="F"), error_count=0)


@dataclass(frozen=True, slots=True)
class PredictionModel:
    """The prediction to be fitted.

    The noisy channel (indicated impact pressure) is predicted from the clean one (ground velocity).
    The parameters are θ = [k1 … kK, W_N, W_E (, W_D)], wind components in m/s toward north, east
    and down.

    `reference_pressure` [Pa] is q_ref of the error model. With `static_error` the error is that of
    the static source and changes the static pressure too. With `wind_down` the vertical wind is a
    parameter.
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
        # Block by block, so that a block's arrays stay in the processor's cache: a long log takes
        # half the time. All blocks take the same number of Newton steps, so the numbers do not
        # depend on the size of a block.
        blocks = _blocks(len(obs))
        for rows in blocks:
            work.place(rows)
        for _ in range(_NEWTON_STEPS):
            step = np.max([work.improve(rows) for rows in blocks])
            if float(step) < _LAST_STEP * float(np.max(work.indicated)):
                break  # convergence is quadratic: the remaining error is far below the step
        for rows in blocks:
            work.differentiate(rows)
        return Prediction(
            work.indicated,
            work.jacobian,
            work.impact,
            work.speed,
            work.slope,
            work.by_error,
            error_count=self.error_count,
        )

    def curve_columns(self, prediction: Prediction, shift: MetersPerSecond) -> MetersPerSecond:
        """Return the change of the predicted airspeed with the parameters of the curve, (n, K).

        The true airspeed is `shift` (n,) [m/s] beyond the predicted one.
        """
        columns = np.empty((self.error_count, len(shift))).T  # contiguous each
        for rows in _blocks(len(shift)):
            slope = prediction.slope[rows]
            x = (prediction.indicated[rows] + shift[rows] * slope) / self.reference_pressure
            columns[rows] = self.error.basis(x) * (prediction.by_error[rows] / slope)[:, None]
        return columns


def _blocks(count: int) -> list[slice]:
    return [slice(first, first + _BLOCK) for first in range(0, count, _BLOCK)]


class _Work:
    """The arrays of a prediction, (n,) each, filled for some rows at a time."""

    def __init__(self, model: PredictionModel, theta: Array, obs: Observations) -> None:
        count = len(obs)
        self._model, self._obs = model, obs
        self._k, self._wind = theta[: model.error_count], theta[model.error_count :]
        self.indicated = obs.impact_pressure.copy()  # Newton's method starts from the measured one
        self.jacobian = np.empty((model.count, count)).T  # contiguous columns
        self.impact, self.speed, self.slope = np.empty(count), np.empty(count), np.empty(count)
        self._x, self.by_error = np.empty(count), np.empty(count)
        # Kept in columns of the Jacobian until they are filled, which saves a long log memory.
        self._ratio, self._ratio_slope, self._by_ratio = self.jacobian[:, :3].T

    def place(self, rows: slice) -> None:
        """Find the impact pressure of ground velocity less wind, also over the static pressure."""
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
        """Take a Newton step to q_ci = F(f(q_ci/q_ref)), and return the largest step [Pa]."""
        model, ratio, impact, q = (
            self._model,
            self._ratio[rows],
            self.impact[rows],
            self.indicated[rows],
        )
        x = q / model.reference_pressure
        f, f_slope = model.error.curve(x, self._k)
        shape = 1.0 / (1.0 + f * ratio) if model.static_error else 1.0
        value = impact * (1.0 - f) * shape
        by_f = -impact * (1.0 + ratio) * shape**2 if model.static_error else -impact
        damping = 1.0 - by_f * f_slope / model.reference_pressure
        step = (value - q) / damping
        q += step
        by_ratio = (
            self._obs.static_pressure[rows] * (1.0 - f) * (shape**2 if model.static_error else 1.0)
        )
        self._by_ratio[rows] = by_ratio / damping
        self._x[rows], self.by_error[rows] = x, by_f / damping
        return float(np.max(np.abs(step)))

    def differentiate(self, rows: slice) -> None:
        """Fill the derivatives by the curve, by the wind and by the true airspeed."""
        error = self._model.error
        by_speed_squared = self._by_ratio[rows] * self._ratio_slope[rows]
        self.jacobian[rows, : self._model.error_count] = (
            error.basis(self._x[rows]) * self.by_error[rows][:, None]
        )
        for column, axis in enumerate(
            self._through_air(rows)[: len(self._wind)], start=self._model.error_count
        ):
            self.jacobian[rows, column] = by_speed_squared * (-2.0 * axis)
        self.slope[rows] = 2.0 * self.speed[rows] * by_speed_squared


def _pressure_ratio(
    north: Array, east: Array, down: Array, probe_temperature: Kelvin, probe_heating: float
) -> tuple[Array, Array, Array]:
    """Return q_c/p of an air velocity, its derivative with respect to V², and V [m/s].

    From V² = M² γRT and T_t = T(1 + 0.2 r M²): M² = V²/(γR T_t − 0.2 r V²).
    """
    squared = north * north + east * east + down * down
    heat = air.HEAT_RATIO * air.GAS_CONSTANT * probe_temperature
    static_heat = heat - probe_heating * squared
    mach_squared = squared / static_heat
    base = 1.0 + 0.2 * mach_squared
    power = base * base * np.sqrt(base)
    return power * base - 1.0, 0.7 * power * heat / (static_heat * static_heat), np.sqrt(squared)


_STEPS_KT = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
_MOST_POINTS = 32
_SLACK_KT = 1.5  # a round airspeed this far outside the data still counts as covered


@dataclass(frozen=True, slots=True)
class CurveMap:
    """A curve at indicated airspeeds (c,), with its gradients, by the error parameters k (K,).

    `indicated_airspeed` [m/s] is the raw reading. `zero` [Pa] is the zero offset of the impact
    pressure in it; q_ci is the reading minus the offset.
    """

    model: PredictionModel
    indicated_airspeed: MetersPerSecond
    zero: float = 0.0

    def impact_pressure(self) -> Pascal:
        """Return q_ci at the curve's airspeeds, less the sensor's zero offset, (c,) [Pa]."""
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
        impact_share = 1.0 - self.normalized(k)
        pressure = self.impact_pressure() / impact_share
        return (
            self.basis()
            * (air.calibrated_airspeed_slope(pressure) * pressure / impact_share)[:, None]
        )

    def correction_by_zero(self, k: Array) -> Array:
        """Derivative of the correction with respect to the zero offset, (c,) [m/s per Pa]."""
        impact_share, reference = 1.0 - self.normalized(k), self.model.reference_pressure
        bend = self.model.error.curve(self.impact_pressure() / reference, k)[1] / reference
        by_indicated = (1.0 + self.impact_pressure() * bend / impact_share) / impact_share
        return np.asarray(
            -air.calibrated_airspeed_slope(self.impact_pressure() / impact_share) * by_indicated
        )

    def altitude(self, k: Array, static_pressure: float) -> Meters:
        """True minus indicated pressure altitude [m], (c,), for an error of the static source.

        `static_pressure` [Pa] is the indicated one. The true one is p = p_i − Δp; a lower pressure
        is a greater altitude.
        """
        error = self.impact_pressure() * (1.0 / (1.0 - self.normalized(k)) - 1.0)
        return air.pressure_altitude(static_pressure - error) - air.pressure_altitude(
            static_pressure
        )

    def altitude_by_total(self, k: Array, static_pressure: float, share: float) -> Meters:
        """Change of the altitude correction [m], (c,), with the total source's error.

        A share of the impact pressure is then the total source's error and not the static source's.
        """
        pressure = self.impact_pressure()
        true = static_pressure - pressure * (1.0 / (1.0 - self.normalized(k)) - 1.0)
        return air.pressure_altitude(true - share * pressure) - air.pressure_altitude(true)

    def altitude_gradient(self, k: Array, static_pressure: float) -> Array:
        """Derivative of the altitude correction with respect to k, (c, K) [m]."""
        impact_share = 1.0 - self.normalized(k)
        pressure = self.impact_pressure()
        true = static_pressure - pressure * (1.0 / impact_share - 1.0)
        temperature = air.standard_temperature(air.pressure_altitude(true))
        meters_a_pascal = air.GAS_CONSTANT * temperature / (true * air.GRAVITY)
        return np.asarray(self.basis() * (meters_a_pascal * pressure / impact_share**2)[:, None])


def curve_airspeeds(indicated_airspeed: MetersPerSecond) -> MetersPerSecond:
    """Return round indicated airspeeds [m/s], (c,), within 0.1 to 99.9 % of the data (n,).

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


def curve_moved(
    model: PredictionModel, obs: Observations, answer: Posterior, moved: Array
) -> CurveMove:
    """Return by how much a change of θ, `moved` (p,), moves the curve of an answer (p + m,)."""
    flown, free = curve_airspeeds(air.calibrated_airspeed(obs.impact_pressure)), model.error_count
    gradient = CurveMap(model, flown).correction_gradient(answer.mean[:free])
    size = np.abs(gradient @ moved[:free])
    bounds = answer.two_sigma(np.pad(gradient, ((0, 0), (0, len(answer.mean) - free))))
    return CurveMove(float(np.max(size)), float(np.max(size / bounds)))
