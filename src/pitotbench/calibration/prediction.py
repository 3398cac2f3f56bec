"""The air data that a ground velocity, a wind, an error curve and nuisances predict.

Its Jacobian is exact.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.special import ndtr

from pitotbench import air
from pitotbench.airdata import LIMITS as GAUGES
from pitotbench.airdata import Rest
from pitotbench.calibration.observations import Blocks, Observations
from pitotbench.calibration.options import (
    WITHOUT_TEMPERATURE,
    Accuracies,
    CalibrationOptions,
    Priors,
    accuracies_of,
    priors_of,
    stated_wind,
)
from pitotbench.estimation.mixture import Posterior
from pitotbench.estimation.noise import Noise
from pitotbench.estimation.restricted_likelihood import Regression
from pitotbench.pressure_error.models import PressureErrorModel
from pitotbench.records.log import CurveMove
from pitotbench.units import DEGREE, KNOT, Array, Kelvin, Meters, MetersPerSecond, Pascal, Seconds

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
        """The change of the predicted airspeed with the curve's parameters, (n, K).

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
        """Find the impact pressure of the ground velocity less the wind.

        It is a share of the static pressure.
        """
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
        """Take one Newton step to the solution of q_ci = F(f(q_ci/q_ref)).

        Return the largest step [Pa].
        """
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
    """q_c/p of an air velocity, its derivative with respect to V², and V [m/s].

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
    """The curve and its gradients as functions of the error parameters k (K,).

    They are at fixed indicated airspeeds (c,).

    `indicated_airspeed` [m/s] is the raw reading. `zero` [Pa] is the zero offset of the impact
    pressure in it; q_ci is the reading minus the offset.
    """

    model: PredictionModel
    indicated_airspeed: MetersPerSecond
    zero: float = 0.0

    def impact_pressure(self) -> Pascal:
        """q_ci at the curve's airspeeds [Pa], (c,).

        It is the pressure at the ports, without the sensor's zero offset.
        """
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
    """Round indicated airspeeds [m/s], (c,), over the range of the data (n,).

    The range is that between its 0.1 and 99.9 percentiles.

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


@dataclass(frozen=True, slots=True)
class WindPath:
    """The wind less its mean, around which a problem is linearized.

    Times (k,) [s], and (k, 2) [m/s] there.

    A wind that drifts far is no small correction to its mean; each pass estimates the path again.
    """

    time: Seconds
    wind: Array

    def at(self, time: Seconds) -> Array:
        """The wind toward north and east at times (n,), (n, 2) [m/s]."""
        return np.stack([np.interp(time, self.time, part) for part in self.wind.T], axis=1)

    def taken_from(self, obs: Observations) -> Observations:
        """The rows with ground velocities less the path, as for a constant wind."""
        north, east = self.at(obs.time).T
        return replace(
            obs,
            velocity_north=obs.velocity_north - north,
            velocity_east=obs.velocity_east - east,
            held_north=obs.held_north - north,
            held_east=obs.held_east - east,
        )


# Error of treating blocks as points, as a share of the process's variance: 0.7 cm/s at 1 m/s.
_COARSE = 5e-5


def kernel_means(blocks: Blocks, correlation_time: float) -> Array:
    """Correlation of the process in each block with its mean over all rows, (blocks,) [-].

    `correlation_time` [s] is that of the process.
    """
    return correlated(blocks, correlation_time, (blocks.count / blocks.count.sum())[:, None])[:, 0]


def correlated(blocks: Blocks, correlation_time: float, values: Array) -> Array:
    """Multiply values of the blocks, (blocks, m), by the process's correlations.

    They are a matrix (blocks, blocks).

    A pass forward and one backward take the place of the matrix, which for a long flight would be
    large.
    """
    decay = np.exp(-np.diff(blocks.middle()) / correlation_time)
    forward, backward = values.copy(), values.copy()
    for row, share in enumerate(decay, start=1):
        forward[row] += share * forward[row - 1]
    for row in range(len(values) - 2, -1, -1):
        backward[row] += decay[row] * backward[row + 1]
    return np.asarray(forward + backward - values)


@dataclass(frozen=True, slots=True)
class MeanWind:
    """The map from an answer for the wind's level to one for its mean, under one noise.

    `winds` are the wind's columns among the coefficients. `weighed` (n, 2) is the transpose of G
    C⁻¹. `unknown` (2, 2) [(m/s)²] is the covariance of the mean, given the data and the level.
    """

    winds: slice
    problem: Regression
    weighed: Array
    unknown: Array

    def of(self, answer: tuple[Array, Array]) -> tuple[Array, Array]:
        """Return the answer with the mean wind in place of the wind's level.

        An answer is an estimate (p,) and a covariance (p, p).
        """
        response, regressors = self.problem.response, self.problem.regressors
        estimate, covariance = answer[0].copy(), answer[1]
        estimate[self.winds] += self.weighed.T @ (response - regressors @ answer[0])
        known = np.eye(len(estimate))
        known[self.winds] -= self.weighed.T @ regressors
        covariance = known @ covariance @ known.T
        covariance[self.winds, self.winds] += self.unknown
        return estimate, 0.5 * (covariance + covariance.T)


def mean_wind(
    noise: Noise, problem: Regression, kernel: Array, deviation: float, first: int
) -> MeanWind:
    """The mean wind of a problem whose wind columns begin at `first`.

    It is the mean over the rows of the log, not the level W of the process: the wind is W + w(t),
    with w a Gauss-Markov process. The data determine its mean over the flight far better than W.
    With G = Cov(mean of w, data), the best prediction adds G C⁻¹(y − Xβ) to the estimate of W
    (Goldberger 1962; Robinson, "That BLUP is a good thing", Statistical Science 6, 1991).

    Parameters: noise, which includes the process; problem; kernel (n,), see `kernel_means`;
    deviation, the standard deviation of the process [m/s]; first.
    """
    winds = slice(first, first + 2)
    crossed = deviation**2 * kernel[:, None] * problem.regressors[:, winds]  # Gᵀ
    weighed = noise.weigh(crossed)
    unknown = deviation**2 * float(np.mean(kernel)) * np.eye(2) - crossed.T @ weighed
    return MeanWind(winds, problem, weighed, _at_least(unknown, _COARSE * deviation**2))


def _at_least(matrix: Array, floor: float) -> Array:
    """A symmetric matrix with eigenvalues raised to a floor."""
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    return np.asarray((vectors * np.maximum(values, floor)) @ vectors.T)


# Wide priors of a wind that changes: by 5 m/s in ten minutes (`linear`), and in 300 m of height
# (every wind but the constant one), is one standard deviation.
_WIND_TIME = 600.0  # s
_WIND_HEIGHT = 300.0  # m
_LEAST_HEIGHT = 1.0  # m: keeps a layer from having no thickness
_LEAST_LAYER = 150.0  # m, of the thinnest layer in which the wind changes by one slope
_MOST_LAYERS = 8

ZERO = "impact_pressure_zero_pa"  # the only nuisance that enters the correction of a reading
LATENCY, SMOOTHING = "latency_s", "receiver_smoothing_s2"
_AXES = ("north", "east")

Column = Callable[[Prediction, Observations], MetersPerSecond]
HeightColumn = Callable[["HeightState"], Array]
Change = Callable[[Observations], Array | float]
Share = Callable[[Pascal, Array], Array]  # of impact pressure and load factor, Δp/q_c per unit


@dataclass(frozen=True, slots=True)
class Nuisance:
    """One unknown with a Gaussian prior of mean zero.

    A nuisance is estimated together with the curve and the wind. It is one number with a mean of
    zero, and its effect on the predicted airspeed is proportional to it. The first order is enough:
    an error of 3 K in the temperature changes the airspeed by 0.5 %, and the neglected second order
    is below 0.003 % of the airspeed.

    `name` ends in the unit and `deviation` is the prior's standard deviation in it. `column` gives
    the change of the predicted true airspeed per unit, (n,) [m/s]. `wind` is the axis (0 north, 1
    east) of one that changes the wind, and its change from row to row; None for another. `height`
    gives the change of the altitude rows per unit [m], None for none; `of_source` states that this
    is an error of the static source, and no other place of the error shows in the height.
    `positive` states that the prior is half-normal. Where its effect is not above `planned`, the
    airspeed says nothing of it. `measured` is what rows outside the flight say of it, with its
    standard deviation; None where they say nothing.
    """

    name: str
    deviation: float
    column: Column
    wind: tuple[int, Change] | None = None
    height: HeightColumn | None = None
    of_source: bool = False
    positive: bool = False
    planned: float = 0.0
    measured: tuple[float, float] | None = None

    def known(self) -> tuple[float, float]:
        """The mean and the precision of what is known before the flight is looked at."""
        value, deviation = self.measured or (0.0, np.inf)
        precision = self.deviation**-2.0 + deviation**-2.0
        return value * deviation**-2.0 / precision, precision


@dataclass(frozen=True, slots=True)
class HeightState:
    """What a column of the altitude rows is made of, (n,) each.

    `gain` are meters per pascal, `impact_pressure` [Pa] is indicated and 0 at rest, `load` is the
    load factor, `climb` [m/s] the climb rate, and `temperature_slope` the change of the column's
    height per kelvin [m/K].
    """

    gain: Array
    impact_pressure: Pascal
    load: Array
    climb: MetersPerSecond
    temperature_slope: Array


def nuisances_of(options: CalibrationOptions, obs: Observations) -> tuple[Nuisance, ...]:
    """The nuisances of a log. The accuracies of its header must already be in the options.

    A nuisance whose accuracy is zero is left out.
    """
    stated, priors = accuracies_of(options.accuracies, {}), priors_of(options.priors)
    temperature = max(stated.temperature_k, WITHOUT_TEMPERATURE if obs.standard_day else 0.0)
    probe_heated = 1.0 if obs.probe_heating > 0.0 else 0.0  # an air temperature needs no recovery
    known = (
        Nuisance(
            "temperature_k",
            0.5 * temperature,
            _by_temperature,
            height=lambda rows: rows.temperature_slope,
        ),
        Nuisance("recovery_factor", 0.5 * stated.recovery_factor * probe_heated, _by_recovery),
        Nuisance("static_pressure_pa", 0.5 * stated.static_pressure_pa, _by_static_pressure),
        _zero(obs.rests, stated, priors),
        *(
            Nuisance(f"velocity_{a}_mps", 0.5 * stated.velocity_mps, _wind(i))
            for i, a in enumerate(_AXES)
        ),
        *_latencies(options, stated, priors, options.use_altitude and obs.altitude is not None),
        Nuisance(SMOOTHING, _smoothing(options, obs), _by_smoothing, positive=True),
        _of_pressure("turn_lift", priors.turn_lift, _turn_lift(obs)),
    )
    change = priors.wind_change_mps
    layers = () if options.wind == "constant" or stated_wind(options.wind) else _layers(obs, change)
    linear = _linear_wind(obs, change) if options.wind == "linear" else ()
    return (*(n for n in known if n.deviation > 0.0), *linear, *layers)


_GUSTY = 2.0  # times its change, the mean pressure of a wind whose gusts are a quarter of it


def _zero(rests: Sequence[Rest], stated: Accuracies, priors: Priors) -> Nuisance:
    """The zero of the impact pressure, as it reads at rest.

    There a wind may blow into the tube, and until the flight the zero moves.
    """
    wide = Nuisance(ZERO, 0.5 * stated.impact_pressure_zero_pa, lambda p, o: 1.0 / p.slope)
    if not rests:
        return wide
    readings = [each.reading_pa for each in rests]
    parts = (
        *(max(_GUSTY * each.gusts_pa for each in rests), max(each.noise_pa for each in rests)),
        *(priors.zero_drift_pa, 0.5 * float(np.ptp(readings))),
    )
    measured = float(np.mean(readings)), float(np.linalg.norm(parts))
    return replace(wide, deviation=max(wide.deviation, GAUGES.zero), measured=measured)


def _smoothing(options: CalibrationOptions, obs: Observations) -> float:
    """The prior of the square of the receiver's time constant [s²].

    A mean over T is a smoothing of T²/12, and a filter of first order one of the square of its
    latency. A velocity from positions is no mean: it was formed along their arcs.
    """
    own = priors_of(options.priors).receiver_smoothing_s2
    apart = float(np.median(np.diff(obs.time[obs.fresh]))) if obs.fresh.sum() > 1 else 0.0
    mean = 0.0 if obs.of_fixes else apart**2 / 12.0
    return (own + mean + options.gps_latency**2) * (own > 0.0)


def with_filter(
    nuisances: Sequence[Nuisance], found: Array, covariance: Array
) -> tuple[Nuisance, ...]:
    """Widen the prior of the smoothing by the mean square of the latency that was found.

    The nuisances have an estimate (m,) and a covariance (m, m). A filter makes both, and none makes
    the velocity early.
    """
    names = [each.name for each in nuisances]
    if LATENCY not in names:
        return tuple(nuisances)
    place = names.index(LATENCY)
    late, spread = float(found[place]), float(np.sqrt(covariance[place, place]))
    share, density = float(ndtr(late / spread)), np.exp(-0.5 * (late / spread) ** 2)
    squared = (late**2 + spread**2) * share + late * spread * density / np.sqrt(2.0 * np.pi)
    return tuple(
        replace(each, deviation=each.deviation + squared) if each.name == SMOOTHING else each
        for each in nuisances
    )


# m/s²: an idle deceleration has 1, the response to moderate turbulence 0.1
_PLANNED = 0.4


def _latencies(
    options: CalibrationOptions, stated: Accuracies, priors: Priors, height: bool
) -> tuple[Nuisance, ...]:
    """The latency of the GPS velocity, and that of its height beyond that of the velocity.

    The ground speed responds to gusts, by an airspeed hold or by drag alone, and these small
    accelerations imitate a latency (simulated flights without latency gave −1.0 to −1.5 s on
    circles and level legs). So only larger ones, planned, are the instrument.
    """
    free = options.latency != "given"
    return (
        Nuisance(
            LATENCY,
            max(0.5 * stated.latency_s, priors.latency_s * free),
            by_latency,
            height=lambda rows: -rows.climb,
            planned=_PLANNED * free,
        ),
        Nuisance(
            "height_latency_s",
            priors.height_latency_s * (free and height),
            lambda prediction, obs: np.zeros(len(obs)),
            height=lambda rows: -rows.climb,
        ),
    )


def with_signs(answer: Posterior, nuisances: Sequence[Nuisance], first: int) -> Posterior:
    """Return an answer in which the nuisances that are `positive` are.

    `first` is the place of the first nuisance.
    """
    for place, nuisance in enumerate(nuisances, start=first):
        if nuisance.positive:
            answer = answer.not_negative(place)
    return answer


def _of_pressure(name: str, deviation: float, share: Share) -> Nuisance:
    """An error of the static source beside the curve of level flight.

    It is a share of the impact pressure.
    """

    def column(prediction: Prediction, obs: Observations) -> MetersPerSecond:
        load = load_factor(_across(prediction, obs))
        return share(prediction.indicated, load) * prediction.by_error / prediction.slope

    def height(rows: HeightState) -> Meters:
        flying = np.maximum(rows.impact_pressure, 1.0)
        return rows.gain * rows.impact_pressure * share(flying, rows.load)

    return Nuisance(name, deviation, column, height=height, of_source=True)


def _turn_lift(obs: Observations) -> Share:
    """What a turn adds to the lift that the curve of level flight holds.

    In a turn the lift coefficient is n/q: the curve holds 1/q, and n − 1 is left. One in the middle
    of the flown ln q_ci.
    """
    low, high = np.quantile(obs.impact_pressure, [0.001, 0.999])
    middle = float(np.sqrt(low * high))
    return lambda impact, load: (load - 1.0) * middle / impact


def in_turns() -> Nuisance:
    """An error of the static source in turns, as sideslip makes it.

    One is the impact pressure at 30° of bank, proportional to the tangent of the bank.
    """
    return _of_pressure(
        "turns", 1.0, lambda impact, load: np.sqrt(load**2 - 1.0) / np.tan(30.0 * DEGREE)
    )


def of_slow_probe(obs: Observations) -> Nuisance:
    """A probe whose error is proportional to 1/q_ci: one is a kelvin at the rows' slow end."""
    slow = float(np.quantile(obs.impact_pressure, 0.001))
    return Nuisance(
        "slow_probe_k",
        1.0,
        lambda p, o: _by_temperature(p, o) * slow / np.maximum(p.indicated, slow),
    )


_BANKED = air.GRAVITY * float(np.tan(10.0 * DEGREE))  # m/s², of a row that counts as turning
_LEAST_TURNING, _ONE_SIDE = 0.1, 0.95  # of the rows, and of those that turn


def side_of_turns(prediction: Prediction, obs: Observations) -> str:
    """The side to which all turns of the rows are, `left` or `right`.

    It is empty where they are to both, or few.
    """
    across = -_across(prediction, obs)
    turning = across[np.abs(across) > _BANKED]
    if len(turning) < _LEAST_TURNING * len(across):
        return ""
    right = float(np.mean(turning > 0.0))
    return "right" if right > _ONE_SIDE else "left" if right < 1.0 - _ONE_SIDE else ""


def along_track(prediction: Prediction) -> Array:
    """Change of the predicted airspeed per unit of wind toward north and east, (n, 2) [-].

    It is minus the direction cosines of the air velocity.
    """
    return prediction.wind_columns[:, :2] / prediction.slope[:, None]


def _linear_wind(obs: Observations, deviation: float) -> tuple[Nuisance, ...]:
    """The wind's change with time, toward north and east."""
    middle = 0.5 * (obs.time[0] + obs.time[-1])
    return _both_axes({"per_600_s": lambda o: (o.time - middle) / _WIND_TIME}, deviation)


def _layers(obs: Observations, deviation: float) -> tuple[Nuisance, ...]:
    """The wind's change with height, a slope a layer of 150 m or more; one slope over less."""
    low, high = (float(edge) for edge in np.quantile(obs.height(), [0.01, 0.99]))
    high = max(high, low + _LEAST_HEIGHT)
    count = min(max(int((high - low) / _LEAST_LAYER), 1), _MOST_LAYERS)
    edges = np.linspace(low, high, count + 1)
    if count == 1:
        changes = {"per_300_m": _slope(obs, low, high)}
    else:
        changes = {
            f"per_300_m_above_{low:.0f}_m": _slope(obs, low, high) for low, high in pairwise(edges)
        }
    # Over many heights the changes of a wind add up as those of a random walk do.
    thickness = max((high - low) / count, _WIND_HEIGHT)
    return _both_axes(changes, deviation * float(np.sqrt(_WIND_HEIGHT / thickness)))


def _slope(flown: Observations, low: float, high: float) -> Change:
    """A change by one in 300 m between two heights [m], zero in the mean of what was flown.

    Below and above there is none.
    """
    middle = float(np.mean(np.clip(flown.height(), low, high)))
    return lambda obs: (np.clip(obs.height(), low, high) - middle) / _WIND_HEIGHT


def _both_axes(changes: Mapping[str, Change], deviation: float) -> tuple[Nuisance, ...]:
    return tuple(
        Nuisance(f"wind_{name}_mps_{unit}", deviation, _wind(axis, change), (axis, change))
        for unit, change in changes.items()
        for axis, name in enumerate(_AXES)
    )


def path_of_nuisances(nuisances: Sequence[Nuisance], values: Array, obs: Observations) -> Array:
    """Return the wind that nuisances of given values (m,) add to each row.

    It is toward north and east, (n, 2) [m/s].
    """
    added = np.zeros((len(obs), 2))
    for nuisance, value in zip(nuisances, values, strict=True):
        if nuisance.wind is not None:
            axis, change = nuisance.wind
            added[:, axis] += value * change(obs)
    return added


def _wind(axis: int, change: Change = lambda obs: 1.0) -> Column:
    """The effect of a wind toward an axis (0 north, 1 east), times its change from row to row."""
    return lambda prediction, obs: along_track(prediction)[:, axis] * change(obs)


def _by_temperature(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    # V = M sqrt(γRT): the same ground velocity in warmer air is a smaller Mach number and impact
    # pressure.
    return -0.5 * prediction.true_airspeed / obs.probe_temperature


def _by_recovery(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    # T = T_t/(1 + 0.2 r M²): more recovery means colder air for the same reading.
    heat = air.HEAT_RATIO * air.GAS_CONSTANT * obs.probe_temperature
    return 0.1 * prediction.true_airspeed**3 / heat


def _by_static_pressure(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    # The impact pressure of a Mach number is proportional to the static pressure.
    return prediction.indicated / (obs.static_pressure * prediction.slope)


def by_latency(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    """Change of the predicted airspeed per second of GPS latency, (n,) [m/s].

    It is the ground acceleration along it.
    """
    return np.asarray(-np.einsum("na,na->n", along_track(prediction), obs.acceleration))


def _across(prediction: Prediction, obs: Observations) -> Array:
    """The acceleration over the ground across the path through the air, (n,) [m/s²]."""
    north, east = along_track(prediction).T
    return np.asarray(north * obs.acceleration[:, 1] - east * obs.acceleration[:, 0])


def _by_smoothing(prediction: Prediction, obs: Observations) -> MetersPerSecond:
    """Change of the predicted airspeed per s² of τ², the smoothing of the velocity.

    A velocity that turns at ω and is smoothed over τ is too short by 1/√(1 + ω²τ²), of which the
    first term is kept.

    A mean over T is a smoothing with τ² = T²/12.
    """
    return np.asarray(0.5 * _across(prediction, obs) ** 2 / prediction.true_airspeed)


def load_factor(across: Array) -> Array:
    """The load factor of a level turn, (n,) [-], by the acceleration across it, (n,) [m/s²]."""
    return np.asarray(np.hypot(1.0, across / air.GRAVITY))
