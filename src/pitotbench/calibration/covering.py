"""The estimator of the covering 2σ: generalized least squares with the noise estimated from the
log.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise

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
from pitotbench.calibration.observations import Blocks, Observations, block_length, divide
from pitotbench.calibration.options import PRIORS, Priors
from pitotbench.calibration.output_error import OutputErrorFit
from pitotbench.calibration.prediction import (
    Nuisance,
    PredictionModel,
    WindPath,
    along_track,
    correlated,
    kernel_means,
    mean_wind,
    path_of_nuisances,
)
from pitotbench.estimation.noise import (
    NORMAL,
    Intervals,
    JointNoiseOf,
    MarkovNoise,
    MarkovProcess,
    NoiseOf,
)
from pitotbench.estimation.restricted_likelihood import (
    LogPrior,
    NoiseNode,
    Regression,
    Solution,
    half_width,
    most_likely_noise,
    noise_posterior,
    simultaneous_factor,
    solutions,
    solve,
)
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import Estimate, WindowWind
from pitotbench.units import Array

# The covering estimator's problem at one point: block means, their regressors and the family of
# their noise. The residual of the block means is white sensor noise plus the gust along the flight
# path. The gust is a horizontal vector. Its two components are first-order Gauss-Markov processes
# with the length of the Dryden spectrum (MIL-F-8785C; 533 m above 2,000 ft) under a wide prior. In
# a turn the flight path points along one component, then along the other.

_HIGH = 69682.0  # Pa, standard pressure at 10,000 ft
_LEAST_WHITE = 0.02  # m/s, least start of the search for the white level
_ROUNDING = 1e-16  # variance of a number that is known
_WHITE_FLOOR = 1e-8  # (m/s)²: keeps the covariance regular for logs without noise


@dataclass(frozen=True, slots=True)
class Structure:
    """The structure to be fitted: the prediction, the nuisances, the equations and the priors.

    `drifting` states whether the wind drifts. `altitude` holds the rows of the altitude equation,
    for an error of the static source in a log with heights.
    """

    model: PredictionModel
    nuisances: tuple[Nuisance, ...]
    drifting: bool
    priors: Priors = PRIORS
    altitude: AltitudeRows | None = None


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

    With the parameters of the noise, φ (d,), two effects of it are taken off. Gusts across the
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
    columns = [nuisance.column(prediction, obs) for nuisance in structure.nuisances]
    regressors = blocks.mean(
        np.column_stack([prediction.jacobian / prediction.slope[:, None], *columns])
    )
    airspeed, slope = blocks.mean(prediction.true_airspeed), blocks.mean(prediction.slope)
    sensor = (_sensor_noise(obs) / slope) ** 2 / blocks.count
    if noise is not None:
        response -= np.exp(2.0 * noise[0]) / airspeed
    if (
        path is not None
    ):  # the problem is one of the whole wind, not of its difference from the path
        response += blocks.mean(np.sum(along_track(prediction) * path.at(obs.time), axis=1))
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
    regression = Regression(
        response,
        regressors,
        smoothed(regressors, blocks, structure.priors.instruments_s),
        *_priors(structure, theta),
    )
    kernel = kernel_means(blocks, memory) if structure.drifting else None
    problem = Linearized(regression, noise_of, sensor, kernel)
    return (
        problem
        if structure.altitude is None
        else _with_altitude(problem, structure, structure.altitude, theta)
    )


def _priors(structure: Structure, theta: Array) -> tuple[Array, Array]:
    """The precisions of the rival priors, (r, p + m), and their mean (p + m,), of a correction to
    θ (p,): the model's of its parameters, none of the wind, the accuracies' of the nuisances.
    """
    model, law = structure.model, structure.model.error.precisions
    winds = np.zeros((len(law), model.count - model.error_count))
    known = np.array([1.0 / n.deviation**2 for n in structure.nuisances])
    mean = np.zeros(model.count + len(known))
    mean[: model.error_count] = -theta[: model.error_count]
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


def _sensor_noise(obs: Observations) -> float:
    """White noise of the impact pressure [Pa], from its second differences (slow signals cancel)."""
    second = np.diff(obs.impact_pressure, 2)
    return float(NORMAL * np.median(np.abs(second)) / np.sqrt(6.0))


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
        variance = self.sensor + levels[..., 2, None] ** 2 + _WHITE_FLOOR
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
    """The prior of a drifting wind's standard deviation [m/s]: it grows with the root of the time
    beyond the wind's memory.
    """
    priors = structure.priors
    times = float(obs.time[-1] - obs.time[0]) / priors.slow_wind_s
    return priors.slow_wind_mps * max(1.0, float(np.sqrt(times)))


def length_factor(structure: Structure, obs: Observations) -> float:
    """One standard deviation of the prior of the gusts' length, as a factor.

    It is greater for a log above 10,000 ft, unless a drifting wind stands for the slow part.
    """
    if structure.drifting:
        return structure.priors.gust_length_factor
    high = float(np.median(obs.static_pressure)) < _HIGH
    priors = structure.priors
    return priors.high_length_factor if high else priors.gust_length_factor


def log_prior_of(structure: Structure, obs: Observations) -> LogPrior:
    """The prior of φ: half-normal levels and a log-normal length, wider for a log above 10,000 ft.

    The φ terms convert the density of a level to that of its logarithm. The gust's level has no φ
    term (Jeffreys' prior for a scale). A density that is flat in the level would put gusts of a few
    centimeters a second into calm air, which outweigh all sensor noise.
    """
    rows = structure.altitude
    priors = structure.priors
    levels = {0: (priors.gust_mps, 0.0), 2: (priors.white_mps, 1.0)}
    if structure.drifting:
        levels[3] = (wind_scale(structure, obs), 1.0)
    usual, factor = np.log(priors.gust_length_m), np.log(length_factor(structure, obs))

    def log_prior(phi: Array) -> float:
        half_normal = sum(
            flat * phi[i] - 0.5 * (np.exp(phi[i]) / scale) ** 2
            for i, (scale, flat) in levels.items()
        )
        length = -0.5 * ((phi[1] - usual) / factor) ** 2
        height = 0.0 if rows is None else altitude_log_prior(rows, phi[-NOISE_COUNT:])
        return float(half_normal + length) + height

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
    rest = response - regressors @ np.linalg.lstsq(regressors, response)[0]
    total = max(float(np.mean(rest**2)), _WHITE_FLOOR)
    once, twice = (max(float(np.mean(rest[k:] * rest[:-k])), 0.05 * total) for k in (1, 2))
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


# The noise is white sensor noise plus gusts. Their levels and length are unknown. They
# are estimated by restricted likelihood, and the answer is averaged over their posterior.

_LEAST_PLANNED = (
    10.0  # (m/s²)² s: a second of latency must have moved the airspeed by more than gusts do
)
_PASSES = 10  # at most
_FAR = 4.0  # standard errors: a longer step is followed by another
_SMOOTH_PATH = 300.0  # s: a path that follows each gust would bend the problem along its own noise
_SAME_PATH = (
    2.0  # m/s, rms between two paths of the wind: what is left is second order, 4 cm/s at 50 m/s
)


@dataclass(frozen=True, slots=True)
class CoveringFit:
    """A fit: θ0, the nodes of the noise posterior and the most likely noise.

    `theta` (p + m,) is the reference point θ0, zero for the m nuisances; the nodes hold corrections
    to it. The deviations of gust and drifting wind are in m/s, the gust length in m; `blocks` is
    the number of blocks. `path` is that of a drifting wind, and `winds` its mean in each window;
    None and empty for another wind.
    """

    theta: Array
    nodes: tuple[NoiseNode, ...]
    gust_deviation: float
    gust_length: float
    wind_deviation: float
    blocks: int
    problem: Regression  # linearized at θ0
    noise_of: NoiseOf
    path: WindPath | None = None
    winds: tuple[WindowWind, ...] = ()


@dataclass(frozen=True, slots=True)
class FirstPass:
    """The result of the first pass: θ (p,), the most likely noise φ, and the path of a drifting
    wind.

    `solutions` are the answers under each rival prior of the curve: corrections to θ and the
    nuisances, (p + m,), with their covariance. θ is that of the likeliest.
    """

    theta: Array
    noise: Array
    solutions: tuple[Solution, ...]
    path: WindPath | None = None


def fit_covering(
    structure: Structure, obs: Observations, start: Array, path: WindPath | None = None
) -> CoveringFit:
    """Fit from a nearby start θ (p,), and of a drifting wind its path.

    Every node's estimate is a correction to the returned θ.

    The first pass, on blocks twice as long, moves θ to the estimate under the most likely noise.
    The last pass linearizes there and gives the bound. Raises NoAnswerError where the log is too
    short, the fit leaves the model's domain or the steps do not converge.
    """
    return final_pass(structure, obs, first_pass(structure, obs, start, path))


def final_pass(structure: Structure, obs: Observations, near: FirstPass) -> CoveringFit:
    """Run the last pass of `fit_covering`."""
    length, log_prior = block_length(obs), log_prior_of(structure, obs)
    theta, mode = near.theta, near.noise
    blocks = divide(obs, length)
    fine = linearize(structure, obs, blocks, theta, mode, near.path)
    nodes = noise_posterior(fine.regression, fine.noise_of, log_prior, mode)
    likely = max(nodes, key=lambda node: node.weight)
    best = likely.noise
    return CoveringFit(
        theta=np.concatenate([theta, np.zeros(len(structure.nuisances))]),
        nodes=_of_mean_winds(structure, fine, nodes),
        gust_deviation=float(np.exp(best[0])),
        gust_length=float(np.exp(best[1])),
        wind_deviation=float(np.exp(best[3])) if structure.drifting else 0.0,
        blocks=len(blocks.count),
        problem=fine.regression,
        noise_of=fine.noise_of,
        path=near.path,
        winds=_window_winds(structure, obs, blocks, fine, likely, theta)
        if structure.drifting
        else (),
    )


# The wind of a long flight, window by window.

_WINDOW = 600.0  # s, the longest window
_SHORTEST_WINDOW = 60.0  # s
_GAP = 60.0  # s: a gap that ends a window


def _windows(blocks: Blocks) -> list[slice]:
    """Divide the blocks into windows of ten minutes or less, none across a gap of a minute."""
    middle = blocks.middle()
    ends = [0, *(np.flatnonzero(np.diff(middle) > _GAP) + 1), len(middle)]
    found = []
    for first, end in pairwise(ends):
        lasting = middle[end - 1] - middle[first]
        if lasting >= _SHORTEST_WINDOW:
            edges = np.linspace(
                middle[first], middle[end - 1], int(np.ceil(lasting / _WINDOW)) + 1
            )[1:-1]
            cuts = [first, *np.searchsorted(middle, edges), end]
            found += [slice(int(a), int(b)) for a, b in pairwise(cuts)]
    return found


def _window_winds(
    structure: Structure,
    obs: Observations,
    blocks: Blocks,
    problem: Linearized,
    node: NoiseNode,
    theta: Array,
) -> tuple[WindowWind, ...]:
    """The mean wind of each window under the most likely noise."""
    noise, deviation = problem.noise_of(node.noise), float(np.exp(node.noise[3]))
    first, data = structure.model.error_count, problem.regression
    winds, rest = slice(first, first + 2), len(data.response) - len(blocks.count)
    known = np.zeros((2, len(node.estimate)))
    known[:, winds] = np.eye(2)
    changes = np.zeros((len(blocks.count), 2, len(structure.nuisances)))
    for place, nuisance in enumerate(structure.nuisances):
        if nuisance.wind is not None:
            changes[:, nuisance.wind[0], place] = blocks.mean(
                np.broadcast_to(nuisance.wind[1](obs), len(obs))
            )
    height, time = blocks.mean(obs.height()), blocks.mean(obs.time)
    windows, found = _windows(blocks), []
    shares = np.zeros((len(blocks.count), len(windows)))
    for number, window in enumerate(windows):
        shares[window, number] = blocks.count[window] / blocks.count[window].sum()
    kernels = correlated(blocks, structure.priors.slow_wind_s, shares)
    for window, weights, kernel in zip(windows, shares.T, kernels.T, strict=True):
        of_level = known.copy()
        of_level[:, structure.model.count :] = np.einsum("b,ban->an", weights, changes)
        crossed = (
            deviation**2 * np.append(kernel, np.zeros(rest))[:, None] * data.regressors[:, winds]
        )
        weighed = noise.weigh(crossed)
        value = theta[winds] + of_level @ node.estimate
        value = value + weighed.T @ (data.response - data.regressors @ node.estimate)
        of_level -= weighed.T @ data.regressors
        unknown = deviation**2 * float(weights @ kernel) * np.eye(2) - crossed.T @ weighed
        covariance = of_level @ node.covariance @ of_level.T + unknown
        north, east = (
            Estimate(axis, float(value[i]), 2.0 * float(np.sqrt(max(covariance[i, i], 0.0))))
            for i, axis in enumerate(("north", "east"))
        )
        span = float(time[window][0]), float(time[window][-1])
        found.append(WindowWind(*span, float(weights @ height), north, east))
    return tuple(found)


def _of_mean_winds(
    structure: Structure, problem: Linearized, nodes: Sequence[NoiseNode]
) -> tuple[NoiseNode, ...]:
    """The nodes with the mean wind where the wind drifts; those of one noise share its wind."""
    found: list[NoiseNode] = []
    for _, group in groupby(nodes, key=lambda node: tuple(node.noise)):
        alike = list(group)
        answers = _of_mean_wind(structure, problem, alike[0].noise, alike)
        found += [
            replace(node, estimate=estimate, covariance=covariance)
            for node, (estimate, covariance) in zip(alike, answers, strict=True)
        ]
    return tuple(found)


def _of_mean_wind(
    structure: Structure, problem: Linearized, phi: Array, answers: Sequence[Solution | NoiseNode]
) -> list[tuple[Array, Array]]:
    """The estimates and covariances of answers under one noise, with the mean wind where the wind
    drifts.
    """
    found = [(each.estimate, each.covariance) for each in answers]
    if problem.kernel is None:
        return found
    deviation, first = float(np.exp(phi[3])), structure.model.error_count
    mean = mean_wind(problem.noise_of(phi), problem.regression, problem.kernel, deviation, first)
    return [mean.of(each) for each in found]


def first_pass(
    structure: Structure, obs: Observations, start: Array, path: WindPath | None = None
) -> FirstPass:
    """Run the first pass of `fit_covering`, repeated from a start (p,) or a path that is far away.

    Raises NoAnswerError where the log is too short for its unknowns or the steps do not converge.
    """
    theta, mode, count, log_prior = start, None, structure.model.count, log_prior_of(structure, obs)
    blocks = divide(obs, 2.0 * block_length(obs))
    unknowns = count + noise_count(structure)
    if len(blocks.count) <= unknowns:
        raise NoAnswerError(
            f"by its clock the log lasts {obs.time[-1] - obs.time[0]:.3g} s, too short for "
            f"{unknowns} unknowns: "
            "check the unit of the time, or fly longer"
        )
    for _ in range(_PASSES):
        rough = linearize(structure, obs, blocks, theta, path=path)
        guess = first_guess(rough, structure) if mode is None else mode
        mode = most_likely_noise(rough.regression, rough.noise_of, log_prior, guess)
        found = solutions(rough.regression, rough.noise_of(mode))
        best = int(np.argmax([each.weight for each in found]))
        # The next point has the mean wind: the level of a drifting wind may be far from any wind of
        # the flight.
        moved = _of_mean_wind(structure, rough, mode, found)
        step, covariance = moved[best]
        theta, last = theta + step[:count], path
        if structure.drifting:
            path = _path(structure, obs, blocks, rough, mode, found[best].estimate)
        if np.all(
            np.abs(step[:count]) < _FAR * np.sqrt(np.diag(covariance)[:count])
        ) and _has_converged(last, path):
            return FirstPass(
                theta,
                mode,
                tuple(
                    Solution(each.weight, estimate - step, spread)
                    for each, (estimate, spread) in zip(found, moved, strict=True)
                ),
                path,
            )
    raise NoAnswerError(
        "the fit does not converge: check the log for gross errors, or choose a simpler model"
    )


def _path(
    structure: Structure,
    obs: Observations,
    blocks: Blocks,
    problem: Linearized,
    phi: Array,
    estimate: Array,
) -> WindPath:
    """The wind less its mean over the rows, as estimated under one noise, block by block."""
    wind = _process(structure, blocks, problem, phi, estimate)
    wind += blocks.mean(
        path_of_nuisances(structure.nuisances, estimate[structure.model.count :], obs)
    )
    wind = smoothed(wind, blocks, _SMOOTH_PATH)
    return WindPath(blocks.mean(obs.time), wind - np.average(wind, axis=0, weights=blocks.count))


def _process(
    structure: Structure, blocks: Blocks, problem: Linearized, phi: Array, estimate: Array
) -> Array:
    """The slow process of the wind, as estimated under one noise, (blocks, 2) [m/s]."""
    data, first = problem.regression, structure.model.error_count
    rest = problem.noise_of(phi).weigh((data.response - data.regressors @ estimate)[:, None])
    seen = (rest * data.regressors[:, first : first + 2])[
        : len(blocks.count)
    ]  # the height sees no wind
    memory = structure.priors.slow_wind_s
    return np.asarray(np.exp(2.0 * phi[3]) * correlated(blocks, memory, seen))


def drift_of(structure: Structure, obs: Observations, fit: CoveringFit, answer: Array) -> WindPath:
    """Return the slow part of a drifting wind, less the wind of an answer (p + m,).

    It is the estimate for the answer's curve and constants, under the most likely noise. It is
    smooth: one that follows each gust would leave no residual.
    """
    count, first = structure.model.count, structure.model.error_count
    blocks, phi = divide(obs, block_length(obs)), max(fit.nodes, key=lambda n: n.weight).noise
    problem = linearize(structure, obs, blocks, answer[:count], phi, fit.path)
    data, estimate = problem.regression, np.zeros(len(answer))
    estimate[count:] = answer[count:]
    winds = data.regressors[:, first : first + 2]
    weighed = problem.noise_of(phi).weigh(winds)
    left = data.response - data.regressors @ estimate
    level = np.linalg.solve(weighed.T @ winds, weighed.T @ left)
    estimate[first : first + 2] = level
    wind = level + _process(structure, blocks, problem, phi, estimate)
    return WindPath(blocks.mean(obs.time), smoothed(wind, blocks, _SMOOTH_PATH))


def _has_converged(before: WindPath | None, path: WindPath | None) -> bool:
    """Whether another path of the wind would hardly change the problem.

    The path before may be that of other rows, as before a faulty one was left out.
    """
    if path is None:
        return True
    moved = path.wind if before is None else path.wind - before.at(path.time)
    return float(np.sqrt(np.mean(moved**2))) < _SAME_PATH


def covariance_given(
    structure: Structure, obs: Observations, blocks: Blocks, theta: Array, phi: Array
) -> Array:
    """Covariance of θ and the nuisances, (p + m, p + m), for a known noise.

    φ = ln(gust deviation [m/s], gust length [m], white deviation [m/s]). It is the inverse
    information matrix and does not depend on the response.
    """
    problem = linearize(structure, obs, blocks, theta)
    return solve(problem.regression, problem.noise_of(phi))[1]


def acceleration_effect(
    structure: Structure, obs: Observations, fit: CoveringFit, column: Nuisance
) -> Estimate:
    """Estimate one more nuisance, without a prior, on one-second blocks, and return it with 2σ.

    The noise is the most likely one with this nuisance. Its instrument is its smoothed column where
    that exceeds
    `column.deviation`: such accelerations are planned and not a response to gusts. 2σ is infinite
    where there are
    too few of them.
    """
    blocks, structure = (
        divide(obs, max(1.0, 0.5 * block_length(obs))),
        replace(structure, altitude=None),
    )
    theta = fit.theta[: structure.model.count]
    plain = linearize(structure, obs, blocks, theta, path=fit.path)
    added = blocks.mean(column.column(structure.model.predict(theta, obs), obs))
    smooth = smoothed(added, blocks, structure.priors.instruments_s)
    planned = np.where(np.abs(smooth) > column.deviation, smooth, 0.0)
    if float(planned @ planned) < _LEAST_PLANNED:
        return Estimate(column.name, 0.0, float("inf"))
    wider = plain.regression.with_column(added, planned)
    best = max(fit.nodes, key=lambda node: node.weight).noise
    mode = best[: noise_count(structure)]
    if not structure.drifting:  # of a long flight one latency changes the likely noise little
        mode = most_likely_noise(wider, plain.noise_of, log_prior_of(structure, obs), mode)
    estimate, covariance = solve(wider, plain.noise_of(mode))
    return Estimate(column.name, float(estimate[-1]), 2.0 * float(np.sqrt(covariance[-1, -1])))


@dataclass(frozen=True, slots=True)
class Posterior:
    """Weighted Gaussians for θ: weights (m,), which sum to 1, means (m, p) and covariances (m, p,
    p).
    """

    weights: Array
    means: Array
    covariances: Array

    @property
    def mean(self) -> Array:
        """The mixture's mean, (p,)."""
        return np.asarray(self.weights @ self.means)

    @property
    def covariance(self) -> Array:
        """The mixture's covariance, (p, p)."""
        offset = self.means - self.mean
        within = np.einsum("m,mpq->pq", self.weights, self.covariances)
        return np.asarray(within + np.einsum("m,mp,mq->pq", self.weights, offset, offset))

    def padded(self, count: int) -> "Posterior":
        """The same answer with further unknowns that are zero but for rounding, of `count` unknowns
        in all.
        """
        more = count - self.means.shape[1]
        covariances = np.pad(self.covariances, ((0, 0), (0, more), (0, more)))
        covariances[:, range(-more, 0), range(-more, 0)] = _ROUNDING
        return Posterior(self.weights, np.pad(self.means, ((0, 0), (0, more))), covariances)

    def two_sigma(self, gradient: Array) -> Array:
        """2σ of linear functions of θ with gradient (c, p), as half-widths of the mixture, (c,)."""
        means = self.means @ gradient.T
        variances = np.einsum("cp,mpq,cq->mc", gradient, self.covariances, gradient)
        with np.errstate(
            invalid="ignore"
        ):  # a negative variance gives a NaN bound, which `require_useful` refuses
            deviations = np.sqrt(variances)
        return half_width(self.weights, means, deviations)

    def correlation(self, gradient: Array) -> Array:
        """Correlation of the errors of linear functions of θ with gradient (c, p), as (c, c)."""
        covariance = gradient @ self.covariance @ gradient.T
        with np.errstate(invalid="ignore"):  # as above
            deviation = np.sqrt(np.diag(covariance))
            return np.asarray(covariance / np.outer(deviation, deviation))

    def simultaneous(self, gradient: Array, bounds: Array) -> Array:
        """Half-widths that hold at all points together: the pointwise `bounds` (c,) times one
        factor.
        """
        return bounds * simultaneous_factor(
            self.weights, self.means, self.covariances, gradient, bounds
        )

    def two_sigma_by(self, place: int, gradient: Array, bounds: Array) -> Array:
        """The part of the 2σ `bounds`, (c,), that the uncertainty of θ[place] adds: none where
        θ[place] is known.

        It is the bound times the correlation with θ[place], so that no part exceeds the whole.
        """
        covariance = self.covariance
        variance = (
            np.einsum("cp,pq,cq->c", gradient, covariance, gradient) * covariance[place, place]
        )
        shared = np.abs(gradient @ covariance[:, place])
        whole = np.sqrt(np.maximum(variance, np.finfo(np.float64).tiny))
        return np.asarray(bounds * np.clip(shared / whole, 0.0, 1.0))


def posterior_of(fit: OutputErrorFit | CoveringFit) -> Posterior:
    """The posterior of a fit: one Gaussian for output error, a mixture for the covering estimator."""
    if isinstance(fit, OutputErrorFit):
        return Posterior(np.ones(1), fit.theta[None], fit.covariance[None])
    return Posterior(
        np.array([node.weight for node in fit.nodes]),
        fit.theta + np.stack([node.estimate for node in fit.nodes]),
        np.stack([node.covariance for node in fit.nodes]),
    )
