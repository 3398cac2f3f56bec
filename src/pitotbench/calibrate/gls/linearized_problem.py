"""The covering estimator's problem at one point: block means, their regressors and the family of their noise.

The residual of the block means is white sensor noise plus the gust along the flight path. The gust is a horizontal
vector. Its two components are first-order Gauss-Markov processes with the length of the Dryden spectrum
(MIL-F-8785C; 533 m above 2,000 ft) under a wide prior. In a turn the flight path points along one component, then
along the other.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from pitotbench.calibrate.gls.altitude_noise import NOISE_COUNT, AltitudeNoise, altitude_guess, altitude_log_prior
from pitotbench.calibrate.gls.altitude_rows import AltitudeRows, altitude_regression
from pitotbench.calibrate.model.mean_wind import kernel_means
from pitotbench.calibrate.model.nuisances import Nuisance
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.rows.blocks import Blocks
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.estimate.joint_noise import JointNoiseOf, NoiseOf
from pitotbench.estimate.markov_noise import Intervals, MarkovNoise, MarkovProcess
from pitotbench.estimate.restricted_likelihood import LogPrior, Regression
from pitotbench.estimate.robust_scale import NORMAL
from pitotbench.records.errors import NoAnswerError
from pitotbench.units import Array

GUST_LENGTH = 533.0  # m, Dryden, above 2,000 ft (MIL-F-8785C)
GUST_LENGTH_FACTOR = 2.5  # one standard deviation of the prior on it, as a factor
HIGH_LENGTH_FACTOR = 4.0  # above 10,000 ft, where the slow wind aloft has no outer scale near that length
GUST_SCALE = 2.0  # m/s, half-normal prior on the gust's standard deviation
WHITE_SCALE = 0.5  # m/s, half-normal prior on the white part that is not the pressure sensor's
WIND_SCALE = 1.0  # m/s, half-normal prior on a drifting wind's standard deviation
WIND_TIME = 1800.0  # s, its correlation time: longer than most maneuvers, so nearly a random walk
_HIGH = 69682.0  # Pa, standard pressure at 10,000 ft
_LEAST_WHITE = 0.02  # m/s, least start of the search for the white level
_WHITE_FLOOR = 1e-8  # (m/s)²: keeps the covariance regular for logs without noise
_SMOOTHING = 3.0  # s, width of the zero-phase filter that makes the instruments


@dataclass(frozen=True, slots=True)
class Structure:
    """The structure to be fitted: the prediction, the nuisances and the equations.

    `drifting` states whether the wind drifts. `altitude` holds the rows of the altitude equation, for an error of
    the static source in a log with heights.
    """

    model: PredictionModel
    nuisances: tuple[Nuisance, ...]
    drifting: bool
    altitude: AltitudeRows | None = None


@dataclass(frozen=True, slots=True)
class Linearized:
    """The problem linearized at one θ, as block means.

    `regression` [m/s] holds the airspeeds of the blocks, then the altitude rows [m] where the structure has them.
    `noise_of` gives the noise for parameters φ. `sensor` (blocks,) [(m/s)²] is the pressure
    sensor's part of the noise along the path. `kernel` is the correlation of each datum with the mean of a drifting
    wind, None for another wind.
    """

    regression: Regression
    noise_of: NoiseOf
    sensor: Array
    kernel: Array | None


def linearize(
    structure: Structure, obs: Observations, blocks: Blocks, theta: Array, gust_variance: float = 0.0
) -> Linearized:
    """Linearize the problem at θ (p,).

    Gusts across the flight path lengthen the airspeed vector by σ²/V on average, with σ² = `gust_variance`
    [(m/s)²]; this is subtracted. Raises NoAnswerError where θ is outside the model's domain.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        prediction = structure.model.predict(theta, obs)
    if not np.isfinite(np.sum(prediction.jacobian)) or not np.all(prediction.slope != 0.0):
        raise NoAnswerError(
            "the fit leaves the domain of the model (no airspeed explains some rows): "
            "check the clock and the units, also of part of the log, or choose a model with fewer parameters"
        )
    response = blocks.mean((obs.impact_pressure - prediction.indicated) / prediction.slope)
    columns = [nuisance.column(prediction, obs) for nuisance in structure.nuisances]
    regressors = blocks.mean(np.column_stack([prediction.jacobian / prediction.slope[:, None], *columns]))
    airspeed, slope = blocks.mean(prediction.true_airspeed), blocks.mean(prediction.slope)
    sensor = (_sensor_noise(obs) / slope) ** 2 / blocks.count
    response -= gust_variance / airspeed
    precision = [0.0] * structure.model.count + [1.0 / n.deviation**2 for n in structure.nuisances]
    regression = Regression(response, regressors, smoothed(regressors, blocks), np.array(precision))
    # A residual falls by the wind component along its direction: these are the direction cosines.
    first = structure.model.error_count
    seen = -regressors[None, :, first : first + 2]
    kernel = kernel_means(blocks, WIND_TIME) if structure.drifting else None
    at_edges = blocks.at_edges(airspeed)
    noise_of = WindNoise(blocks.intervals, at_edges, seen, sensor, structure.drifting)
    problem = Linearized(regression, noise_of, sensor, kernel)
    return problem if structure.altitude is None else _with_altitude(problem, structure, structure.altitude, theta)


def _with_altitude(triangle: Linearized, structure: Structure, rows: AltitudeRows, theta: Array) -> Linearized:
    """The same problem with the altitude rows appended to those of the wind triangle."""
    first, second = triangle.regression, altitude_regression(rows, structure.model, theta, structure.nuisances)
    both = Regression(
        np.concatenate([first.response, second.response]),
        np.concatenate([first.regressors, second.regressors]),
        np.concatenate([first.instruments, second.instruments]),
        first.prior_precision,
    )
    noise_of = JointNoiseOf(
        data=np.column_stack([both.instruments, both.response]),
        first=triangle.noise_of,
        second=AltitudeNoise(rows),
        count=noise_count(structure) - NOISE_COUNT,
        size=len(first.response),
    )
    # The altitude rows do not depend on the wind; the mean remains that over the rows of the triangle.
    kernel = triangle.kernel
    if kernel is not None:
        kernel = np.append(kernel, np.full(len(second.response), float(np.mean(kernel))))
    return replace(triangle, regression=both, noise_of=noise_of, kernel=kernel)


def smoothed(regressors: Array, blocks: Blocks) -> Array:
    """Smooth regressors (blocks, p) into instruments (blocks, p), without their fast noise."""
    return np.asarray(gaussian_filter1d(regressors, _SMOOTHING / blocks.length, axis=0, mode="nearest"))


def _sensor_noise(obs: Observations) -> float:
    """White noise of the impact pressure [Pa], from its second differences (slow signals cancel)."""
    second = np.diff(obs.impact_pressure, 2)
    return float(NORMAL * np.median(np.abs(second)) / np.sqrt(6.0))


@dataclass(frozen=True, slots=True)
class WindNoise:
    """The map from φ to the covariance.

    φ = ln(gust deviation [m/s], gust length [m], white deviation [m/s] (, slow wind's deviation [m/s])).
    `at_edges` are airspeeds at the edges of the intervals [m/s], `seen` (1, blocks, 2) direction cosines, and
    `sensor` (blocks,) the pressure sensor's part of the noise along the path [(m/s)²]. `drifting` is that of the
    structure.
    """

    intervals: Intervals
    at_edges: Array
    seen: Array
    sensor: Array
    drifting: bool

    def __call__(self, phi: Array, /) -> MarkovNoise:
        """Return the covariance for φ (d,)."""
        return self.stack(phi)

    def stack(self, phis: Array) -> MarkovNoise:
        """Return the covariances for many φ, (b, d)."""
        levels = np.exp(phis)
        winds = [MarkovProcess(levels[..., 0], levels[..., 1, None] / self.at_edges, self.seen)]
        if self.drifting:
            winds.append(MarkovProcess(levels[..., 3], np.full(len(self.at_edges), WIND_TIME), self.seen))
        variance = self.sensor + levels[..., 2, None] ** 2 + _WHITE_FLOOR
        return MarkovNoise(self.intervals, variance[..., None, :], winds)


def length_factor(obs: Observations) -> float:
    """One standard deviation of the prior of the gusts' length, as a factor: greater for a log above 10,000 ft."""
    high = float(np.median(obs.static_pressure)) < _HIGH
    return HIGH_LENGTH_FACTOR if high else GUST_LENGTH_FACTOR


def log_prior_of(structure: Structure, obs: Observations) -> LogPrior:
    """The prior of φ: half-normal levels and a log-normal length, wider for a log above 10,000 ft.

    The φ terms convert the density of a level to that of its logarithm. The gust's level has no φ term (Jeffreys'
    prior for a scale). A density that is flat in the level would put gusts of a few centimeters a second into calm
    air, which outweigh all sensor noise.
    """
    rows = structure.altitude
    levels = {0: (GUST_SCALE, 0.0), 2: (WHITE_SCALE, 1.0)}
    if structure.drifting:
        levels[3] = (WIND_SCALE, 1.0)
    factor = length_factor(obs)

    def log_prior(phi: Array) -> float:
        half_normal = sum(
            flat * phi[i] - 0.5 * (np.exp(phi[i]) / scale) ** 2 for i, (scale, flat) in levels.items()
        )
        length = -0.5 * ((phi[1] - np.log(GUST_LENGTH)) / np.log(factor)) ** 2
        height = 0.0 if rows is None else altitude_log_prior(rows, phi[-NOISE_COUNT:])
        return float(half_normal + length) + height

    return log_prior


def noise_count(structure: Structure) -> int:
    """The number of parameters of the noise."""
    return 3 + structure.drifting + (0 if structure.altitude is None else NOISE_COUNT)


def first_guess(problem: Linearized, structure: Structure) -> Array:
    """A start for φ (d,) from the least-squares residual of the airspeed.

    The covariance of neighboring blocks is attributed to gusts. The rest, without the sensor's noise, is white.
    """
    data, blocks = problem.regression, len(problem.sensor)
    response, regressors = data.response[:blocks], data.regressors[:blocks]
    rest = response - regressors @ np.linalg.lstsq(regressors, response)[0]
    total = max(float(np.mean(rest**2)), _WHITE_FLOOR)
    once, twice = (max(float(np.mean(rest[k:] * rest[:-k])), 0.05 * total) for k in (1, 2))
    gust = min(once**2 / twice, total)  # an exponential correlation, carried back to lag zero
    white = max(total - gust - float(np.mean(problem.sensor)), _LEAST_WHITE**2)
    start = [np.sqrt(gust), GUST_LENGTH, np.sqrt(white), *[0.3 * WIND_SCALE] * structure.drifting]
    height = np.zeros(0) if structure.altitude is None else altitude_guess(structure.altitude)
    return np.concatenate([np.log(start), height])
