"""Whether the wind of a log changed: the evidence, and the answer averaged over changes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from pitotbench.calibration.altitude import NOISE_COUNT, AltitudeNoise, altitude_regression
from pitotbench.calibration.covering import CoveringFit
from pitotbench.calibration.covering_problem import Linearized, Structure, linearize, log_prior_of
from pitotbench.calibration.observations import Blocks, Observations, block_length, divide
from pitotbench.calibration.prediction import curve_moved
from pitotbench.estimation.evidence import ColumnEvidence, EvidencePart, column_evidence
from pitotbench.estimation.mixture import Posterior
from pitotbench.estimation.noise import MarkovNoise, MarkovProcess
from pitotbench.estimation.point_noise import PointNoise, UnknownColumns, ornstein_uhlenbeck
from pitotbench.estimation.restricted_likelihood import LogPrior, Regression
from pitotbench.records.calibration import WindChange
from pitotbench.records.log import Caution
from pitotbench.scatter import deviation_of_sizes, white_differences
from pitotbench.timeline import minutes_text
from pitotbench.units import KNOT, Array, MetersPerSecond, Seconds, percent_text

# Degrees (1σ) of the heading's error: constant, with 1/q over the log, and in ten minutes.
DIRECTION_DEVIATIONS = np.array([5.0, 2.0, 0.5])
_TEN_MINUTES = 600.0  # s
# rad/s: in a faster turn a heading lags, and a sideslip comes with the bank
_STRAIGHT = np.radians(1.0)
_FEWEST = 10  # straight blocks
_WANDER = 0.2  # m/s, least level of the wander of heading and path
_WANDER_TIME = 20.0  # s, its correlation time
_LAG = 10.0  # s between rows whose differences show the level
_WHITE = 0.05  # m/s, least white noise of a block


@dataclass(frozen=True, slots=True)
class HeadingRows:
    """Means over the straight blocks, (n,), of the ground velocity to the right of the heading.

    `straight` (n,) are the numbers of these blocks and `right` (n, 2) their unit vectors to the
    right, toward north and east. `directions` (n, 3) [m/s per degree] are the effects of the errors
    of the heading.
    """

    straight: NDArray[np.intp]
    response: MetersPerSecond
    right: Array
    directions: Array
    noise: PointNoise


def heading_rows(
    obs: Observations, blocks: Blocks, airspeed: MetersPerSecond
) -> HeadingRows | None:
    """Compute the rows; None for a log without heading or straight flight.

    The rows give the wind across the heading, without an airspeed. `airspeed` (blocks,) is the true
    one. Without sideslip the velocity through the air points along the heading, so the ground
    velocity across the heading is the wind across it. A heading is a few degrees off, which at 60
    m/s are meters a second. But most of this error is the same over a log, follows the speed (the
    trim in sideslip) or drifts slowly (a gyro), so the rows show whether the wind changed. Gusts
    hardly count: they turn the airplane's path over the ground slowly.
    """
    if obs.heading is None:
        return None
    right = np.stack([-np.sin(obs.heading), np.cos(obs.heading)], axis=1)
    ground = np.stack([obs.velocity_north, obs.velocity_east], axis=1)
    east, north = (blocks.mean(right) * [-1.0, 1.0]).T
    turn = np.abs(np.gradient(np.unwrap(np.arctan2(east, north)), blocks.length)) > _STRAIGHT
    near_turn = turn | np.append(turn[1:], False) | np.append(False, turn[:-1])
    straight = np.flatnonzero(~near_turn)
    if len(straight) < _FEWEST:
        return None
    time = blocks.intervals.edges[blocks.intervals.left[straight]]
    pressure, middle = blocks.mean(obs.impact_pressure)[straight], 0.5 * (time[0] + time[-1])
    response, right = (
        blocks.mean(np.sum(ground * right, axis=1))[straight],
        blocks.mean(right)[straight],
    )
    shapes = [
        np.ones(len(time)),
        float(np.median(pressure)) / pressure - 1.0,
        (time - middle) / _TEN_MINUTES,
    ]
    per_degree = np.radians(1.0) * airspeed[straight, None]
    return HeadingRows(
        straight,
        response,
        right,
        per_degree * np.stack(shapes, axis=1),
        _heading_noise(time, response),
    )


def _heading_noise(time: Seconds, response: MetersPerSecond) -> PointNoise:
    """Return white noise and a slow wander by differences of neighbors and of rows further apart.

    Medians of differences do not see a single change of the wind.
    """
    step = float(np.median(np.diff(time)))
    white = max(deviation_of_sizes(np.abs(white_differences(response))), _WHITE)
    lag = max(round(_LAG / step), 1)
    together = time[lag:] - time[:-lag] < 1.5 * lag * step
    distances = (
        deviation_of_sizes(np.abs(response[lag:] - response[:-lag])[together])
        if together.any()
        else 0.0
    )
    wander = max(
        distances / float(np.sqrt(2.0 * (1.0 - np.exp(-lag * step / _WANDER_TIME)))), _WANDER
    )
    slow = ornstein_uhlenbeck(time, wander, _WANDER_TIME, (1.0,))
    return PointNoise(
        np.full((1, len(time)), white**2),
        [slow],
        UnknownColumns(np.zeros((len(time), 0)), np.zeros(0)),
    )


STEADY, WAVE, DRIFT, JUMP = "steady", "wave", "drift", "jump"
# Bayes factor of a change from which on it may be named. Below a third the log supports a constant
# wind; from there to three it says nothing worth more than a mention (Kass and Raftery 1995).
MIN_BAYES_FACTOR = 1.0 / 3.0
_STEADY_SIZES = (1.0, 3.0)  # m/s (1σ) of each component, over the log
# m/s, standard deviation of a component of the wind around its mean over the log
_SIZES = (0.4, 1.2, 3.6)
_MEMORIES = (60.0, 600.0)  # s of a drift: a wave, a steady change
_LEAST_INTERVAL = 0.1  # s between rows: a wind that changes is slow
_PERIODS = (160.0, 230.0, 330.0, 470.0)  # s, of a wave
_WAVE_SIZES = (0.5, 1.5)  # m/s (1σ) of each of its coefficients
_SHORTEST = 30.0  # s, half a period of the fastest cosine: shorter changes are gusts
_MOST_COSINES = 24  # in a long log the slower ones
_MOMENTS = 200  # at which winds are compared for the size of a change
_JUMP_SIZE = 3.0  # m/s (1σ) of each component
_JUMP_SECONDS = 20.0  # s that a jump lasts
_JUMP_TIMES = 30  # that are tried, evenly over the log
# Of the gust length found for a constant wind, which takes a change for long gusts.
_SHORTER = (1.0, 0.4, 0.15)
_DRAWS = 1000  # logs with a constant wind
_SEED = 1  # of these draws
_FLOOR = 1e-8  # (m/s)²: keeps the covariance regular for logs without noise
_CHANGES = 0.5  # probability, before the log is seen, that the wind changed by one of the shapes
_LEAST_WEIGHT = 1e-3  # of a change in the answer


@dataclass(frozen=True, slots=True)
class _Change:
    """A kind of change: columns' places (k,), prior deviations [m/s] (k,), and ln of its share."""

    kind: str
    places: NDArray[np.intp]
    deviations: Array
    log_share: float
    time: float = 0.0


@dataclass(frozen=True, slots=True)
class _Shapes:
    """Changes of a component of the wind, (blocks, s) [-], and their means over the log.

    `changes` are what they may be.
    """

    of_time: Array
    means: Array
    changes: tuple[_Change, ...]


def check_wind(
    structure: Structure, every: Observations, fit: CoveringFit, answer: Posterior
) -> tuple[WindChange | None, Posterior]:
    """Weigh changes of the wind against a fit's constant one, and average the answer over them.

    The answer is averaged over a constant wind and over changes of it, each with its probability
    given the log (Bayesian model averaging: Hoeting et al., Statistical Science 14, 1999). A change
    is a sum of known shapes with unknown sizes: a straight line, a wave, slow cosines for a drift,
    one step for a front. Where each speed is flown once, the airspeed alone often cannot tell a
    change of the wind from a curve. The heading helps (`heading_rows`). Background: Kass and
    Raftery, "Bayes factors", Journal of the American Statistical Association 90 (1995).

    Returns what was found, and the mixture over a constant wind and its changes. A log too short
    for a change has None and the answer as it is.
    """
    obs, blocks = _slow_rows(every)
    shapes = _shapes(blocks)
    if shapes is None:
        return None, answer
    evidence_at = _evidence(
        structure, obs, blocks, fit.theta[: structure.model.count], shapes.of_time, fit.likely.rival
    )
    weighed = _weigh(evidence_at, fit.likely.noise, log_prior_of(structure, obs), shapes.changes)
    change, likely, moved = weighed.change, weighed.sizes, weighed.moved[: structure.model.count]
    sizes = likely.reshape(2, -1)
    some = shapes.of_time[:: len(shapes.of_time) // _MOMENTS + 1, change.places[: sizes.shape[1]]]
    winds = some @ sizes.T
    distances = np.linalg.norm(winds[:, None] - winds[None], axis=-1)
    log_factor = weighed.log_factor
    factor = float(np.exp(min(log_factor, 700.0)))
    time = change.time if change.kind == JUMP else np.nan
    moves = curve_moved(structure.model, every, answer, moved)
    steady = (1.0 - _CHANGES) * np.exp(-max(log_factor, 0.0))
    averaged = _averaged(answer, steady, weighed, shapes, structure.model.error_count)
    size = float(np.max(distances))
    return WindChange(
        factor, weighed.chance(), change.kind, size, time, moves.most, moves.share
    ), averaged


def _slow_rows(every: Observations) -> tuple[Observations, Blocks]:
    """The rows that a slow change needs, and their blocks."""
    obs = every.every(max(round(_LEAST_INTERVAL / float(np.median(np.diff(every.time)))), 1))
    return obs, divide(obs, 2.0 * block_length(obs))


@dataclass(frozen=True, slots=True)
class _Weighed:
    """The evidence for changes under some noises.

    `found` is that under each noise, `odds` (noises, changes) that of each pair, and `log_factor`
    by which some change is likelier than none.
    """

    changes: Sequence[_Change]
    found: list[ColumnEvidence]
    odds: Array
    log_factor: float

    @property
    def place(self) -> tuple[int, int]:
        """The likeliest noise and change."""
        noise, place = np.unravel_index(int(np.argmax(self.odds)), self.odds.shape)
        return int(noise), int(place)

    @property
    def change(self) -> _Change:
        """The likeliest change."""
        return self.changes[self.place[1]]

    @property
    def sizes(self) -> Array:
        """The likeliest sizes of its columns, (k,)."""
        information = self.found[self.place[0]].information
        return information.posterior(self.change.places, self.change.deviations).mean

    @property
    def moved(self) -> Array:
        """What it moves of all unknowns, (p,)."""
        return np.asarray(self.found[self.place[0]].moved[:, self.change.places] @ self.sizes)

    def chance(self) -> float:
        """The probability of so much evidence where nothing changes, by draws."""
        drawn = _gains(self.found[0], self.found[0].information.drawn(_DRAWS, _SEED), self.changes)
        return float(np.mean(logsumexp(drawn, axis=0) >= self.log_factor))


def _weigh(
    evidence_at: Callable[[Array], ColumnEvidence],
    likely: Array,
    log_prior: LogPrior,
    changes: Sequence[_Change],
) -> _Weighed:
    """Weigh changes under the likely noise of a steady fit, (d,), and under shorter gusts."""
    noises = [_shorter(likely, ratio) for ratio in _SHORTER]
    found = [evidence_at(phi) for phi in noises]
    heights = np.array(
        [each.log_likelihood + log_prior(phi) for each, phi in zip(found, noises, strict=True)]
    )
    gains = [_gains(each, each.information.inner[-1:, :-1], changes)[:, 0] for each in found]
    odds = heights[:, None] + np.array(gains) - logsumexp(heights)
    return _Weighed(changes, found, odds, float(logsumexp(odds)))


_GAIN = 0.05  # 1σ of a step of the factor
_LEAST_GAIN = 0.01  # the least step that is named
_LEAST_LOG_ODDS = 3.0  # logarithm by which a step of the factor must be likelier than a changed or a constant wind
_CLEAR_STEP = 4.0  # standard errors of a step by the rows' own scatter
_OWN_SCATTER = 30.0  # s, of the blocks of that scatter
_GAIN_CHANCE = 0.01  # of a constant factor in the same gusts, above which no step is named


def check_gain(
    structure: Structure,
    every: Observations,
    fit: CoveringFit,
    answer: Posterior,
    change: WindChange | None,
) -> tuple[Caution, ...]:
    """Warn of a step of the impact pressure's factor that neither wind nor chance explains.

    The answer stays: where each speed is flown once a step is hard to separate from a curve, and an
    average over it would widen the bound of every log.
    """
    obs, blocks = _slow_rows(every)
    theta = fit.theta[: structure.model.count]
    triangle = linearize(replace(structure, altitude=None), obs, blocks, theta)
    prediction = structure.model.predict(theta, obs)
    time, first = blocks.middle(), structure.model.error_count
    times = np.linspace(time[0], time[-1], _JUMP_TIMES + 2)[1:-1]
    effect = blocks.mean(obs.impact_pressure / prediction.slope)
    regression, along = triangle.regression, -triangle.regression.regressors[:, first : first + 2]
    airspeed = blocks.mean(prediction.true_airspeed)
    columns = effect[:, None] * (time[:, None] > times)

    def evidence(phi: Array) -> ColumnEvidence:
        noise = _triangle_noise(blocks, triangle, along, airspeed, phi)
        part = EvidencePart(regression.response, regression.instruments, columns, noise)
        return column_evidence([part], *regression.prior(fit.likely.rival))

    share, one = float(-np.log(len(times))), np.array([_GAIN])
    steps = [_Change("gain", np.array([i]), one, share) for i in range(len(times))]
    weighed = _weigh(evidence, fit.likely.noise, log_prior_of(structure, obs), steps)
    size, place = float(weighed.sizes[0]), weighed.place[1]
    of_wind = 0.0 if change is None else float(np.log(max(change.bayes_factor, 1.0)))
    if (
        weighed.log_factor < of_wind + _LEAST_LOG_ODDS
        or abs(size) < _LEAST_GAIN
        or weighed.chance() > _GAIN_CHANCE
        or _by_own_scatter(regression, columns[:, place], time) < _CLEAR_STEP
    ):
        return ()
    when = minutes_text(float(times[place] - every.time[0]))
    moves = curve_moved(structure.model, every, answer, weighed.moved[: structure.model.count])
    text = (
        f"the impact pressure seems to change by {percent_text(size, '+')} from {when} of the rows "
        "used on, more than gusts or a change of the wind explain, which "
        f"moves the curve by up to {moves.most / KNOT:.2f} kt: "
        "look for ice, a leak or another source"
    )
    return (Caution(text, "gain", "impact_pressure", size, moves),)


def _by_own_scatter(problem: Regression, column: Array, time: Seconds) -> float:
    """Return by how many standard errors, from the rows' own scatter, a column's size is off zero.

    Gusts that come in bursts make a step where they are strong; the error of blocks of 30 s sees
    that (Liang and Zeger 1986).
    """
    both = np.column_stack([column, problem.response])
    own, response = (both - problem.instruments @ np.linalg.lstsq(problem.instruments, both)[0]).T
    size = float(own @ response) / float(own @ own)
    scores = np.bincount(
        ((time - time[0]) // _OWN_SCATTER).astype(np.intp), own * (response - size * own)
    )
    return abs(size) * float(own @ own) / float(np.sqrt(scores @ scores))


def _averaged(
    answer: Posterior,
    steady: float,
    weighed: _Weighed,
    shapes: _Shapes,
    first: int,
) -> Posterior:
    """Return the mixture over a constant wind, of weight `steady`, and the changes.

    The weights of the changes are (noises, changes). The wind, from the place `first` on, is its
    mean over the log.
    """
    shares = _CHANGES * np.exp(weighed.odds - max(weighed.log_factor, 0.0))
    mean_wind = np.zeros((len(answer.mean), 2 * len(shapes.means)))
    mean_wind[first, : len(shapes.means)] = mean_wind[first + 1, len(shapes.means) :] = shapes.means
    total, count = steady + float(shares.sum()), len(answer.mean)
    mean, covariance = answer.mean, answer.covariance
    weights, means, covariances = (
        [answer.weights * (steady / total)],
        [answer.means],
        [answer.covariances],
    )
    for noise, place in np.argwhere(shares > _LEAST_WEIGHT * total):
        change, evidence = shapes.changes[int(place)], weighed.found[int(noise)]
        moved = evidence.moved[:count, change.places] + mean_wind[:, change.places]
        sizes = evidence.information.posterior(change.places, change.deviations)
        weights.append(shares[noise, place, None] / total)
        means.append((mean + moved @ sizes.mean)[None])
        covariances.append((covariance + moved @ sizes.covariance @ moved.T)[None])
    kept = np.concatenate(weights)
    return Posterior(kept / kept.sum(), np.concatenate(means), np.concatenate(covariances))


def _gains(evidence: ColumnEvidence, pulls: Array, changes: Sequence[_Change]) -> Array:
    """The log Bayes factor of each change with its share, (changes, d), for pulls (d, m)."""
    return np.array(
        [
            evidence.information.log_evidences(pulls, change.places, change.deviations)
            + change.log_share
            for change in changes
        ]
    )


def _shorter(noise: Array, ratio: float) -> Array:
    """A noise with another gust length and the same gusts over short times."""
    phi = noise.copy()
    phi[:2] += np.log(ratio) * np.array([0.5, 1.0])
    return phi


def _shapes(blocks: Blocks) -> _Shapes | None:
    """The changes that are weighed, each kind with the same probability."""
    edges = blocks.intervals.edges
    time, duration = blocks.middle() - edges[0], float(edges[-1] - edges[0])
    count = min(int(duration / _SHORTEST), _MOST_COSINES)
    if count < 1:
        return None
    number = np.arange(1, count + 1)
    cosines = np.cos(np.pi * np.outer(time / duration, number))
    times = np.linspace(0.0, duration, _JUMP_TIMES + 2)[1:-1]
    steady = (time / duration - 0.5)[:, None]
    jumps = np.clip((time[:, None] - times) / _JUMP_SECONDS + 0.5, 0.0, 1.0)
    angles = 2.0 * np.pi * time[:, None] / np.array(_PERIODS)
    of_time = np.hstack([cosines, steady, jumps, np.cos(angles), np.sin(angles)])
    shapes, first_wave = of_time.shape[1], count + 1 + _JUMP_TIMES
    shares = {
        STEADY: 1.0 / len(_STEADY_SIZES),
        WAVE: 1.0 / (len(_PERIODS) * len(_WAVE_SIZES)),
        DRIFT: 1.0 / (len(_MEMORIES) * len(_SIZES)),
        JUMP: 1.0 / _JUMP_TIMES,
    }
    share = {kind: float(np.log(part / len(shares))) for kind, part in shares.items()}
    changes = [
        _Change(STEADY, _both(np.array([count]), shapes), np.full(2, size), share[STEADY])
        for size in _STEADY_SIZES
    ]
    for place in range(first_wave, first_wave + len(_PERIODS)):
        both = _both(np.array([place, place + len(_PERIODS)]), shapes)
        changes += [_Change(WAVE, both, np.full(4, size), share[WAVE]) for size in _WAVE_SIZES]
    for memory in _MEMORIES:
        spread = _spread(number, duration, memory)
        changes += [
            _Change(DRIFT, _both(number - 1, shapes), np.tile(size * spread, 2), share[DRIFT])
            for size in _SIZES
        ]
    changes += [
        _Change(
            JUMP,
            _both(np.array([count + 1 + i]), shapes),
            np.full(2, _JUMP_SIZE),
            share[JUMP],
            float(middle),
        )
        for i, middle in enumerate(times)
    ]
    return _Shapes(of_time, blocks.count @ of_time / blocks.count.sum(), tuple(changes))


def _spread(number: NDArray[np.intp], duration: float, memory: float) -> Array:
    """Return deviations of the cosines' coefficients by a unit Gauss-Markov process' spectrum."""
    power = 1.0 / (1.0 + (np.pi * number * memory / duration) ** 2)
    return np.asarray(np.sqrt(2.0 * power / np.sum(power)))


def _both(places: NDArray[np.intp], shapes: int) -> NDArray[np.intp]:
    """The places of some shapes of the north and of the east component."""
    return np.concatenate([places, places + shapes])


def _evidence(
    structure: Structure,
    obs: Observations,
    blocks: Blocks,
    theta: Array,
    of_time: Array,
    rival: int,
) -> Callable[[Array], ColumnEvidence]:
    """The map from a noise φ to the evidence for changes of the wind, under one rival prior."""
    triangle = linearize(replace(structure, altitude=None), obs, blocks, theta)
    first, regression = structure.model.error_count, triangle.regression
    winds, added = slice(first, first + 2), len(DIRECTION_DEVIATIONS)
    ground = blocks.mean(np.stack([obs.velocity_north, obs.velocity_east], axis=1))
    airspeed = np.linalg.norm(ground - theta[winds], axis=1)
    heading = heading_rows(obs, blocks, airspeed)
    along = -regression.regressors[:, winds]
    known, pull = regression.prior(rival)
    precision = np.append(known, 1.0 / DIRECTION_DEVIATIONS**2)
    pull = np.append(pull, np.zeros(added))

    def evidence(phi: Array) -> ColumnEvidence:
        noise = _triangle_noise(blocks, triangle, along, airspeed, phi)
        wide = np.pad(regression.instruments, ((0, 0), (0, added)))
        parts = [EvidencePart(regression.response, wide, _changing(-along, of_time), noise)]
        if heading is not None:
            wide = np.zeros((len(heading.response), len(precision)))
            wide[:, winds], wide[:, -added:] = heading.right, heading.directions
            response = heading.response - heading.right @ theta[winds]
            further = _changing(heading.right, of_time[heading.straight])
            parts.append(EvidencePart(response, wide, further, heading.noise))
        if structure.altitude is not None:
            parts.append(_altitude_part(structure, theta, added, 2 * of_time.shape[1], phi))
        return column_evidence(parts, precision, pull)

    return evidence


def _changing(effects: Array, of_time: Array) -> Array:
    """Return the columns (blocks, 2 s) of changes in time: toward north, then toward east.

    `effects` (blocks, 2) are those of a constant wind.
    """
    return np.concatenate([effects[:, :1] * of_time, effects[:, 1:] * of_time], axis=1)


def _triangle_noise(
    blocks: Blocks, triangle: Linearized, along: Array, airspeed: MetersPerSecond, phi: Array
) -> MarkovNoise:
    """The noise of the triangle's rows: white, and gusts along the path."""
    deviation, length, white = np.exp(phi[:3])
    gusts = MarkovProcess(float(deviation), length / blocks.intervals.at_edges(airspeed), along)
    return MarkovNoise(blocks.intervals, triangle.sensor + white**2 + _FLOOR, [gusts])


def _altitude_part(
    structure: Structure, theta: Array, added: int, changes: int, phi: Array
) -> EvidencePart:
    assert structure.altitude is not None
    rows = altitude_regression(structure.altitude, structure.model, theta, structure.nuisances)
    wide = np.pad(rows.regressors, ((0, 0), (0, added)))
    noise = AltitudeNoise(structure.altitude)(phi[-NOISE_COUNT:])
    return EvidencePart(rows.response, wide, np.zeros((len(wide), changes)), noise)
