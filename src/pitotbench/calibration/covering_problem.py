"""The covering estimator's problem at one point: block means, their regressors and their noise.

The residual of the block means is white sensor noise plus the gust along the flight path. The gust
is a horizontal vector. Its two components are first-order Gauss-Markov processes with the length of
the Dryden spectrum (MIL-F-8785C; 533 m above 2,000 ft) under a wide prior. In a turn the flight
path points along one component, then along the other.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from pitotbench.calibration.altitude import (
    NOISE_COUNT,
    AltitudeNoise,
    AltitudeRows,
    altitude_guess,
    altitude_log_prior,
    altitude_regression,
)
from pitotbench.calibration.nuisances import Nuisance, along_track
from pitotbench.calibration.observations import Blocks, Observations
from pitotbench.calibration.options import PRIORS, Priors, StatedWind
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.calibration.wind_path import WindPath, kernel_means
from pitotbench.estimation.noise import (
    Intervals,
    JointNoiseOf,
    MarkovNoise,
    MarkovProcess,
    NoiseOf,
)
from pitotbench.estimation.restricted_likelihood import LogPrior, Regression
from pitotbench.records import NoAnswerError
from pitotbench.scatter import NORMAL, white_differences
from pitotbench.units import Array

_HIGH = 69682.0  # Pa, standard pressure at 10,000 ft
_LEAST_WHITE = 0.02  # m/s, least start of the search for the white level
WHITE_FLOOR = 1e-8  # (m/s)²: keeps the covariance regular for logs without noise


@dataclass(frozen=True, slots=True)
class Structure:
    """The structure to be fitted: the prediction, the nuisances, the equations and the priors.

    `drifting` states whether the wind drifts. `altitude` holds the rows of the altitude equation,
    for an error of the static source in a log with heights. `wind` is the one that is stated.
    """

    model: PredictionModel
    nuisances: tuple[Nuisance, ...]
    drifting: bool
    priors: Priors = PRIORS
    altitude: AltitudeRows | None = None
    wind: StatedWind | None = None


@dataclass(frozen=True, slots=True)
class Linearized:
    """The problem linearized at one θ, as block means.

    `regression` [m/s] holds the airspeeds of the blocks, then the altitude rows [m] where the
    structure has them. `noise_of` gives the noise for parameters φ. `sensor` (blocks,) [(m/s)²] is
    the pressure sensor's part of the noise along the path. `kernel` is the correlation of each
    datum with the mean of a drifting wind, None for another wind.
    """

    regression: Regression
    noise_of: NoiseOf
    sensor: Array
    kernel: Array | None


def linearize(
    structure: Structure,
    obs: Observations,
    blocks: Blocks,
    theta: Array,
    noise: Array | None = None,
    path: WindPath | None = None,
) -> Linearized:
    """Linearize the problem at θ (p,), for a drifting wind along its `path`.

    Given the parameters of the noise, φ (d,), two of its effects are taken off. Gusts across the
    flight path lengthen the airspeed vector by σ²/V on average. The noise of the ground velocity is
    in the residual and in the airspeeds at which the curve is read; see `_best_airspeed`. Raises
    NoAnswerError where θ is outside the model's domain.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        prediction = structure.model.predict(theta, obs if path is None else path.taken_from(obs))
    if not np.isfinite(np.sum(prediction.jacobian)) or not np.all(prediction.slope != 0.0):
        raise NoAnswerError(
            "the fit leaves the domain of the model (no airspeed explains some rows): "
            "check the clock and the units, also of part of the log, or choose a model with fewer "
            "parameters"
        )
    response = blocks.mean((obs.impact_pressure - prediction.indicated) / prediction.slope)
    # Column by column: of a long log all of them are larger than the log itself.
    columns = [blocks.mean(column / prediction.slope) for column in prediction.jacobian.T]
    prediction = prediction.without_curve()
    columns += [blocks.mean(each.column(prediction, obs)) for each in structure.nuisances]
    regressors = np.stack(columns, axis=1)
    airspeed, slope = blocks.mean(prediction.true_airspeed), blocks.mean(prediction.slope)
    white = NORMAL * float(np.median(np.abs(white_differences(obs.impact_pressure))))  # Pa
    sensor = (white / slope) ** 2 / blocks.count
    if noise is not None:
        response -= np.exp(2.0 * noise[0]) / airspeed
    if (
        path is not None
    ):  # the problem is one of the whole wind, not of its difference from the path
        along = np.einsum("na,na->n", along_track(prediction), path.at(obs.time))
        response += blocks.mean(along)
    # A residual falls by the wind component along its direction: these are the direction cosines.
    first = structure.model.error_count
    seen = -regressors[None, :, first : first + 2]
    at_edges = blocks.intervals.at_edges(airspeed)
    memory = structure.priors.slow_wind_s
    noise_of = WindNoise(
        blocks.intervals, at_edges, seen, sensor, memory if structure.drifting else None
    )
    if noise is not None:
        shift = _best_airspeed(noise_of, noise, response)[blocks.index]
        regressors[:, :first] = blocks.mean(structure.model.curve_columns(prediction, shift))
    instruments = smoothed(regressors, blocks, structure.priors.instruments_s)
    for place, nuisance in enumerate(structure.nuisances, start=structure.model.count):
        if nuisance.planned > 0.0:  # a mean acceleration: smoothed further, it leaves its corners
            column = regressors[:, place]
            instruments[:, place] = np.where(np.abs(column) < nuisance.planned, 0.0, column)
    regression = Regression(response, regressors, instruments, *priors_at(structure, theta))
    kernel = kernel_means(blocks, memory) if structure.drifting else None
    problem = Linearized(regression, noise_of, sensor, kernel)
    return (
        problem
        if structure.altitude is None
        else _with_altitude(problem, structure, structure.altitude, theta)
    )


def priors_at(structure: Structure, theta: Array) -> tuple[Array, Array]:
    """Return the rival priors of a correction to θ (p,): precisions (r, p + m), mean (p + m,).

    The model's of its parameters, that of a wind which is stated, the accuracies' of the nuisances.
    """
    model, law = structure.model, structure.model.error.precisions
    winds = np.zeros((len(law), model.count - model.error_count))
    means, known = np.array([n.known() for n in structure.nuisances]).reshape(-1, 2).T
    mean = np.concatenate([np.zeros(model.count), means])
    mean[: model.error_count] = -theta[: model.error_count]
    if (wind := structure.wind) is not None:
        winds[:, :2] = 1.0 / wind.deviation**2
        at = slice(model.error_count, model.error_count + 2)
        mean[at] = np.array([wind.north, wind.east]) - theta[at]
    return np.hstack([law, winds, np.tile(known, (len(law), 1))]), mean


def _with_altitude(
    triangle: Linearized, structure: Structure, rows: AltitudeRows, theta: Array
) -> Linearized:
    """The same problem with the altitude rows appended to those of the wind triangle."""
    first, second = (
        triangle.regression,
        altitude_regression(rows, structure.model, theta, structure.nuisances),
    )
    both = Regression(
        np.concatenate([first.response, second.response]),
        np.concatenate([first.regressors, second.regressors]),
        np.concatenate([first.instruments, second.instruments]),
        first.prior_precision,
        first.prior_mean,
    )
    noise_of = JointNoiseOf(
        data=np.column_stack([both.instruments, both.response]),
        first=triangle.noise_of,
        second=AltitudeNoise(rows),
        count=noise_count(structure) - NOISE_COUNT,
        size=len(first.response),
    )
    # The altitude rows do not depend on the wind; the mean remains that over the rows of the
    # triangle.
    kernel = triangle.kernel
    if kernel is not None:
        kernel = np.append(kernel, np.full(len(second.response), float(np.mean(kernel))))
    return replace(triangle, regression=both, noise_of=noise_of, kernel=kernel)


def smoothed(values: Array, blocks: Blocks, width: float) -> Array:
    """Smooth values of the blocks, (blocks, p), by a zero-phase filter of a width [s]."""
    return np.asarray(gaussian_filter1d(values, width / blocks.length, axis=0, mode="nearest"))


@dataclass(frozen=True, slots=True)
class WindNoise:
    """The map from φ to the covariance.

    φ = ln(gust deviation [m/s], gust length [m], white deviation [m/s] (, slow wind's deviation
    [m/s])). `at_edges` are airspeeds at the edges of the intervals [m/s], `seen` (1, blocks, 2)
    direction cosines, and `sensor` (blocks,) the pressure sensor's part of the noise along the path
    [(m/s)²]. `memory` [s] is the correlation time of a drifting wind, None for another wind.
    """

    intervals: Intervals
    at_edges: Array
    seen: Array
    sensor: Array
    memory: float | None

    def __call__(self, phi: Array, /) -> MarkovNoise:
        """Return the covariance for φ (d,)."""
        return self.stack(phi)

    def stack(self, phis: Array) -> MarkovNoise:
        """Return the covariances for many φ, (b, d)."""
        levels = np.exp(phis)
        winds = [MarkovProcess(levels[..., 0], levels[..., 1, None] / self.at_edges, self.seen)]
        if self.memory is not None:
            memory = np.full(len(self.at_edges), self.memory)
            winds.append(MarkovProcess(levels[..., 3], memory, self.seen))
        variance = self.sensor + levels[..., 2, None] ** 2 + WHITE_FLOOR
        return MarkovNoise(self.intervals, variance[..., None, :], winds)


def _best_airspeed(noise_of: WindNoise, noise: Array, response: Array) -> Array:
    """The likeliest true airspeed in steady air less the predicted one, (blocks,) [m/s].

    The predicted airspeed has the noise of the ground velocity, and the residual has it with the
    other sign. On a leg in smooth air, where the airspeed hardly changes but for this noise, a
    curve that is read at the predicted airspeed takes it for a slope. The best prediction of the
    noise from the residual r, σ²C⁻¹r (Goldberger 1962), leaves an error that no residual shares. σ
    is the white noise that is not the pressure sensor's.
    """
    return np.asarray(np.exp(2.0 * noise[2]) * noise_of(noise).weigh(response[:, None])[:, 0])


def wind_scale(structure: Structure, obs: Observations) -> float:
    """Return the prior of a drifting wind's standard deviation [m/s].

    Beyond the wind's memory the deviation grows with the root of the time.
    """
    priors = structure.priors
    times = float(obs.time[-1] - obs.time[0]) / priors.slow_wind_s
    return priors.slow_wind_mps * max(1.0, float(np.sqrt(times)))


def length_factor(structure: Structure, obs: Observations) -> float:
    """Return one standard deviation of the prior of the gusts' length, as a factor.

    The factor is greater for a log above 10,000 ft, unless a drifting wind stands for the slow
    part.
    """
    high = float(np.median(obs.static_pressure)) < _HIGH and not structure.drifting
    priors = structure.priors
    return priors.high_length_factor if high else priors.gust_length_factor


def log_prior_of(structure: Structure, obs: Observations) -> LogPrior:
    """The prior of φ: that of the wind and that of the height.

    A log above 10,000 ft has a wider one of the length.
    """
    rows = structure.altitude
    drift = wind_scale(structure, obs) if structure.drifting else None
    of_wind = wind_log_prior(structure.priors, length_factor(structure, obs), drift)
    if rows is None:
        return of_wind
    return lambda phi: of_wind(phi) + altitude_log_prior(rows, phi[-NOISE_COUNT:])


def wind_log_prior(priors: Priors, factor: float, drift: float | None = None) -> LogPrior:
    """Return the prior of the φ of `WindNoise`: half-normal levels and a log-normal length.

    `factor` is one standard deviation of the length, and `drift` [m/s] that of a drifting wind. The
    φ terms convert the density of a level to that of its logarithm. The gust's level has no φ term
    (Jeffreys' prior for a scale). A density that is flat in the level would put gusts of a few
    centimeters a second into calm air, which outweigh all sensor noise.
    """
    levels = {0: (priors.gust_mps, 0.0), 2: (priors.white_mps, 1.0)}
    if drift is not None:
        levels[3] = (drift, 1.0)

    def log_prior(phi: Array) -> float:
        half_normal = sum(
            flat * phi[i] - 0.5 * (np.exp(phi[i]) / scale) ** 2
            for i, (scale, flat) in levels.items()
        )
        length = (phi[1] - np.log(priors.gust_length_m)) / np.log(factor)
        return float(half_normal - 0.5 * length**2)

    return log_prior


def noise_count(structure: Structure) -> int:
    """The number of parameters of the noise."""
    return 3 + structure.drifting + (0 if structure.altitude is None else NOISE_COUNT)


def first_guess(problem: Linearized, structure: Structure) -> Array:
    """A start for φ (d,) from the least-squares residual of the airspeed.

    The covariance of neighboring blocks is attributed to gusts. The rest, without the sensor's
    noise, is white.
    """
    data, blocks = problem.regression, len(problem.sensor)
    response, regressors = data.response[:blocks], data.regressors[:blocks]
    residuals = response - regressors @ np.linalg.lstsq(regressors, response)[0]
    total = max(float(np.mean(residuals**2)), WHITE_FLOOR)
    once, twice = (
        max(float(np.mean(residuals[k:] * residuals[:-k])), 0.05 * total) for k in (1, 2)
    )
    gust = min(once**2 / twice, total)  # an exponential correlation, carried back to lag zero
    white = max(total - gust - float(np.mean(problem.sensor)), _LEAST_WHITE**2)
    priors = structure.priors
    start = [np.sqrt(gust), priors.gust_length_m, np.sqrt(white)]
    start += [0.3 * priors.slow_wind_mps] * structure.drifting
    if (
        structure.drifting and gust > priors.gust_mps**2
    ):  # what is too much for gusts is more likely the wind's drift
        start = [0.5 * priors.gust_mps, priors.gust_length_m, np.sqrt(white), np.sqrt(gust)]
    height = np.zeros(0) if structure.altitude is None else altitude_guess(structure.altitude)
    return np.concatenate([np.log(start), height])
