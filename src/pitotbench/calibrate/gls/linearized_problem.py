"""The covering estimator's problem at one point: block means, what moves them, and the family of their noise.

The residual of block means is white sensor noise plus the gust along the flight path. The gust is a horizontal
vector whose two components are first-order Gauss-Markov processes with the length scale of the Dryden spectrum
(MIL-F-8785C; 533 m above 2,000 ft) under a wide prior; a turn sees first one component, then the other. Where the
direction of the air velocity was measured, a second equation a block sees the component across the path.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from pitotbench import air
from pitotbench.calibrate.gls.altitude_rows import (
    NOISE_COUNT,
    AltitudeRows,
    altitude_guess,
    altitude_log_prior,
    altitude_noise,
    altitude_regression,
)
from pitotbench.calibrate.model.crosswind import crosswind
from pitotbench.calibrate.model.mean_wind import kernel_means
from pitotbench.calibrate.model.nuisances import Nuisance
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.model.wind_jump import JUMP_SCALE, WindJump, jump_columns
from pitotbench.calibrate.rows.blocks import Blocks
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.estimate.added_columns import AddedColumns
from pitotbench.estimate.joint_noise import JointNoiseOf, Noise
from pitotbench.estimate.markov_noise import MarkovNoise, MarkovProcess
from pitotbench.estimate.restricted_likelihood import LogPrior, NoiseOf, Regression
from pitotbench.records.errors import NoAnswerError
from pitotbench.units import Array, MetersPerSecond

GUST_LENGTH = 533.0  # m, Dryden, above 2,000 ft (MIL-F-8785C)
GUST_LENGTH_FACTOR = 2.5  # standard deviation of the prior on it, as a factor
HIGH_LENGTH_FACTOR = 4.0  # above 10,000 ft, where the slow wind aloft has no outer scale near that length
GUST_SCALE = 2.0  # m/s, half-normal prior on the gust's standard deviation
WHITE_SCALE = 0.5  # m/s, half-normal prior on the white part that is not the pressure sensor's
WIND_SCALE = 1.0  # m/s, half-normal prior on a drifting wind's standard deviation
WIND_TIME = 1800.0  # s, its correlation time: longer than most maneuvers, so nearly a random walk
ACROSS_SCALE = 1.0  # m/s, half-normal prior on the white part across the path: 1° of direction at 60 m/s
_HIGH = 69682.0  # Pa, standard pressure at 10,000 ft
_ANSWERS = (10.0, 33.0)  # s, how slowly an airplane is carried across and vertically
_LEAST_WHITE = 0.02  # m/s, where the search for the white level begins at least
_WHITE_FLOOR = 1e-8  # (m/s)²: keeps the covariance regular for logs without noise
_SMOOTHING = 3.0  # s, width of the zero-phase filter that makes the instruments


@dataclass(frozen=True, slots=True)
class Structure:
    """What is fitted: the prediction, the nuisances beside its parameters, whether the wind drifts, whether the
    measured direction of the air velocity is used (`observations.air_heading`), the rows of the altitude equation
    where the error is the static source's and the log has its height, the correlation time of a drifting wind, and
    the one change of a wind that jumps."""

    model: PredictionModel
    nuisances: tuple[Nuisance, ...]
    drifting: bool
    crosswind: bool = False
    altitude: AltitudeRows | None = None
    wind_time: float = WIND_TIME
    jump: WindJump | None = None


@dataclass(frozen=True, slots=True)
class Gusts:
    """Standard deviation [m/s] of each component, and length [m]."""

    deviation: float
    length: float


@dataclass(frozen=True, slots=True)
class Linearized:
    """The problem linearized at one θ, as block means: the regression [m/s], the blocks' airspeeds and after them,
    where the structure asks for it, their crosswinds; the family of its noise; the sensor's part of the noise along
    the path [(m/s)²], (blocks,); and of a drifting wind each datum's correlation with the mean."""

    regression: Regression
    noise_of: NoiseOf
    sensor: Array
    kernel: Array | None


def mean_excess(gusts: Gusts, airspeed: MetersPerSecond, mach: Array) -> MetersPerSecond:
    """By how much gusts lengthen the airspeed found from impact pressure, on average.

    With the same variance along, across and vertically, and an airplane that answers gusts across and vertically
    with the shares ρ of their variance: σ²[3 + M²/(1 + 0.2 M²) − 2 ρ_v − 2 ρ_w]/2V. Gusts along the path count
    because impact pressure grows as V². A share is τ_g/(τ_g + τ_c), with the gust's memory τ_g = L/V. That of the
    airplane, τ_c, is assumed: 10 s across and 33 s vertically (a pilot who holds the height) give the shares 0.45
    and 0.2 of simulated flights of a light twin. An airplane that follows gusts faster has less of it.
    """
    memory = gusts.length / airspeed
    carried = sum(memory / (memory + answer) for answer in _ANSWERS)
    along = mach**2 / (1.0 + 0.2 * mach**2)
    return np.asarray(gusts.deviation**2 * (3.0 + along - 2.0 * carried) / (2.0 * airspeed))


def linearize(
    structure: Structure, obs: Observations, blocks: Blocks, theta: Array, gusts: Gusts | None = None
) -> Linearized:
    """The problem at θ.

    What `gusts` add to the airspeed on average is taken off: see `mean_excess`.
    Raises NoAnswerError where θ is outside the model's domain.
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
    if gusts is not None:
        mach = air.mach_from_impact_pressure(
            blocks.mean(prediction.impact_pressure), blocks.mean(obs.static_pressure)
        )
        response -= mean_excess(gusts, airspeed, mach)
    outputs = [(response, regressors)]
    if structure.crosswind:
        outputs.append(crosswind(structure.model, structure.nuisances, prediction, obs, blocks, theta))
    precision = [0.0] * structure.model.count + [1.0 / n.deviation**2 for n in structure.nuisances]
    regression = Regression(
        np.concatenate([y for y, _ in outputs]),
        np.concatenate([x for _, x in outputs]),
        np.concatenate([smoothed(x, blocks) for _, x in outputs]),
        np.array(precision),
    )
    # A residual falls by the wind component that it sees: these are its direction cosines.
    first = structure.model.error_count
    seen = np.stack([-x[:, first : first + 2] for _, x in outputs])
    kernel = np.tile(kernel_means(blocks, structure.wind_time), len(outputs)) if structure.drifting else None
    problem = Linearized(regression, _noise_family(structure, blocks, airspeed, seen, sensor), sensor, kernel)
    return problem if structure.altitude is None else _with_altitude(problem, structure, structure.altitude, theta)


def _with_altitude(triangle: Linearized, structure: Structure, rows: AltitudeRows, theta: Array) -> Linearized:
    """The same problem with the altitude rows after those of the wind triangle."""
    first, second = triangle.regression, altitude_regression(rows, structure.model, theta, structure.nuisances)
    both = Regression(
        np.concatenate([first.response, second.response]),
        np.concatenate([first.regressors, second.regressors]),
        np.concatenate([first.instruments, second.instruments]),
        first.prior_precision,
    )
    noise_of = JointNoiseOf(
        data=np.column_stack([both.instruments, both.response]),
        instruments=both.instruments,
        first=triangle.noise_of,
        second=lambda phi: altitude_noise(rows, phi),
        count=noise_count(structure) - NOISE_COUNT,
        size=len(first.response),
    )
    # The altitude rows do not move with the wind; the mean stays that over the triangle's rows.
    kernel = triangle.kernel
    if kernel is not None:
        kernel = np.append(kernel, np.full(len(second.response), float(np.mean(kernel))))
    return replace(triangle, regression=both, noise_of=noise_of, kernel=kernel)


def smoothed(regressors: Array, blocks: Blocks) -> Array:
    """Instruments: regressors (blocks, p) without their fast noise."""
    return np.asarray(gaussian_filter1d(regressors, _SMOOTHING / blocks.length, axis=0, mode="nearest"))


def _sensor_noise(obs: Observations) -> float:
    """White noise of the impact pressure [Pa], from its second differences (slow signals cancel)."""
    second = np.diff(obs.impact_pressure, 2)
    return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6.0))


def _noise_family(structure: Structure, blocks: Blocks, airspeed: Array, seen: Array, sensor: Array) -> NoiseOf:
    """φ = ln(gust deviation [m/s], gust length [m], white deviation [m/s] (, slow wind's deviation [m/s]) (, white
    deviation across the path [m/s])) to a covariance; `seen`: direction cosines, (outputs, blocks, 2)."""
    at_edges = blocks.at_edges(airspeed)
    slow = np.full(len(at_edges), structure.wind_time)
    jump = None if structure.jump is None else jump_columns(structure.jump, blocks, seen)

    def noise_of(phi: Array) -> Noise:
        deviation, length, white = np.exp(phi[:3])
        winds = [MarkovProcess(deviation, length / at_edges, seen)]
        if structure.drifting:
            winds.append(MarkovProcess(float(np.exp(phi[3])), slow, seen))
        variance = [sensor + white**2 + _WHITE_FLOOR]
        if structure.crosswind:
            variance.append(np.full_like(sensor, np.exp(2.0 * phi[-1]) + _WHITE_FLOOR))
        noise = MarkovNoise(blocks.intervals, np.stack(variance), winds)
        return noise if jump is None else AddedColumns(noise, jump, JUMP_SCALE)

    return noise_of


def log_prior_of(structure: Structure, obs: Observations) -> LogPrior:
    """Half-normal levels (the φ terms turn densities of a level into densities of its logarithm), log-normal
    length, wider for a log above 10,000 ft.

    The gust's level has no φ term (Jeffreys' prior for a scale): a density that is flat in the level puts a few
    centimeters a second of gusts where there are none, and those outweigh all sensor noise.
    """
    rows = structure.altitude
    levels = {0: (GUST_SCALE, 0.0), 2: (WHITE_SCALE, 1.0)}
    if structure.drifting:
        levels[3] = (WIND_SCALE, 1.0)
    if structure.crosswind:
        levels[3 + structure.drifting] = (ACROSS_SCALE, 1.0)
    high = float(np.median(obs.static_pressure)) < _HIGH
    factor = HIGH_LENGTH_FACTOR if high else GUST_LENGTH_FACTOR

    def log_prior(phi: Array) -> float:
        half_normal = sum(
            flat * phi[i] - 0.5 * (np.exp(phi[i]) / scale) ** 2 for i, (scale, flat) in levels.items()
        )
        length = -0.5 * ((phi[1] - np.log(GUST_LENGTH)) / np.log(factor)) ** 2
        height = 0.0 if rows is None else altitude_log_prior(rows, phi[-NOISE_COUNT:])
        return float(half_normal + length) + height

    return log_prior


def noise_count(structure: Structure) -> int:
    """How many parameters the noise has."""
    return 3 + structure.drifting + structure.crosswind + (0 if structure.altitude is None else NOISE_COUNT)


def first_guess(problem: Linearized, structure: Structure) -> Array:
    """φ from the airspeed's residual of least squares: what neighbors share is gust, what is left beside the sensor
    is white."""
    data, blocks = problem.regression, len(problem.sensor)
    response, regressors = data.response[:blocks], data.regressors[:blocks]
    rest = response - regressors @ np.linalg.lstsq(regressors, response)[0]
    total = max(float(np.mean(rest**2)), _WHITE_FLOOR)
    once, twice = (max(float(np.mean(rest[k:] * rest[:-k])), 0.05 * total) for k in (1, 2))
    gust = min(once**2 / twice, total)  # an exponential correlation, carried back to lag zero
    white = max(total - gust - float(np.mean(problem.sensor)), _LEAST_WHITE**2)
    start = [np.sqrt(gust), GUST_LENGTH, np.sqrt(white)]
    start += [0.3 * WIND_SCALE] * structure.drifting + [0.3 * ACROSS_SCALE] * structure.crosswind
    height = np.zeros(0) if structure.altitude is None else altitude_guess(structure.altitude)
    return np.concatenate([np.log(start), height])
