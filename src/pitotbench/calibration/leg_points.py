"""Fixed-speed points from legs and turns: an airspeed, a wind and a correction for each group, with
bounds.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibration.covering import GUST_LENGTH, GUST_SCALE, WHITE_SCALE
from pitotbench.calibration.legs import (
    SECOND,
    LegAir,
    LikelyLocation,
    SteadyGroup,
    leg_air,
    likely_location,
    location_of,
    steady_groups,
)
from pitotbench.calibration.observations import Observations, observe
from pitotbench.calibration.options import Accuracies, CalibrationOptions, accuracies_of
from pitotbench.calibration.reduction import one_thread
from pitotbench.estimation.noise import Intervals, MarkovNoise, MarkovProcess
from pitotbench.estimation.restricted_likelihood import half_width, weighted_noises
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import Calibration
from pitotbench.records.legs import FixedSpeedPoint
from pitotbench.records.log import FlightLog
from pitotbench.units import DEGREE, Array, MetersPerSecond, Radians, Seconds

# The bound of a fixed-speed answer, from the gusts and the sensor noise that the legs show. The
# residual of ground velocity and air data, without airspeed and wind, is white noise plus the gust
# along the flight path. The gust is a horizontal first-order Gauss-Markov vector of Dryden's
# length. The levels come from all legs and turns of the log together, by restricted likelihood. The
# methods are not least squares, so each plausible noise is propagated with the weights of the
# method. The bound is that of the mixture over the noises. The likelihood treats the gusts of
# different groups as independent. Each group's airspeed and wind then need only a 4 x 4 matrix of
# products, and the cost is proportional to the length of the log instead of its cube. Within a
# group all correlations count. Compared with the likelihood of all legs at once, no 2σ of the five
# maneuvers and three data systems changes by more than 0.02 %.

_FLOOR = 1e-4  # m/s: keeps the covariance regular for legs without noise
# One standard deviation of the prior on the gust length, as a factor. Legs of half a minute tell
# little about it.
_LENGTH_FACTOR = 1.6
_FORGOTTEN = (
    1e5  # s, between groups: some thousand correlation times, so their gusts are independent
)
_TOUCHING = (
    1.01 * SECOND
)  # s, greatest distance between the middles of two blocks that share an edge


@dataclass(frozen=True, slots=True)
class LinearizedGroup:
    """A group linearized at its answer.

    `time` (n,) [s] is the middle of each second, `residual` (n,) [m/s] that of ground velocity
    against airspeed and wind, and `along` (n, 2) the unit vector of the flight path. `gain` (n, 3)
    is the change of the answer [V, W_N, W_E] per residual in each second [-]. `airspeed` [m/s] is
    the true one.
    """

    time: Seconds
    residual: Array
    along: Array
    gain: Array
    airspeed: float

    def in_order(self) -> "LinearizedGroup":
        """Return the group sorted by time."""
        order = np.argsort(self.time)
        return LinearizedGroup(
            self.time[order],
            self.residual[order],
            self.along[order],
            self.gain[order],
            self.airspeed,
        )


def two_sigma(groups: Sequence[LinearizedGroup]) -> list[Array]:
    """Compute 2σ of the airspeed and the wind components [m/s], (3,), of each group."""
    ordered = [group.in_order() for group in groups]
    noises, weights = plausible_noises(ordered)
    means = np.zeros((len(weights), 3))
    return [
        half_width(weights, means, np.sqrt(answer_variances(group, noises))) for group in ordered
    ]


def plausible_noises(groups: Sequence[LinearizedGroup]) -> tuple[Array, Array]:
    """Return the nodes of the noise's posterior, (m, 3), and their weights, (m,).

    A node is ln(gust deviation [m/s], gust length [m], white deviation [m/s]). Each group must be
    sorted by time.
    """
    level = float(np.concatenate([group.residual for group in groups]).std())
    if level < _FLOOR:  # computed legs without noise
        return np.log([[_FLOOR, GUST_LENGTH, _FLOOR]]), np.ones(1)
    likelihood = LegLikelihood(groups)

    def log_posterior(noise: Array) -> float:
        try:
            return likelihood.of(noise) + _log_prior(noise)
        except np.linalg.LinAlgError:
            return -np.inf  # the search rejects this noise

    return weighted_noises(log_posterior, np.log([level, GUST_LENGTH, 0.3 * level]))


def _log_prior(phi: Array) -> float:
    """The prior of the covering method: half-normal levels, log-normal length, as densities of the
    logarithms.
    """
    deviation, white = np.exp(phi[0]), np.exp(phi[2])
    levels = (
        -0.5 * (deviation / GUST_SCALE) ** 2 - 0.5 * (white / WHITE_SCALE) ** 2 + phi[0] + phi[2]
    )
    return float(levels - 0.5 * ((phi[1] - np.log(GUST_LENGTH)) / np.log(_LENGTH_FACTOR)) ** 2)


class LegLikelihood:
    """The restricted likelihood of the noise. Each group has a separate airspeed and wind.

    Parameters: groups, each sorted by time.
    """

    def __init__(self, groups: Sequence[LinearizedGroup]) -> None:
        lengths = [len(group.time) for group in groups]
        self._first = np.cumsum([0, *lengths[:-1]])
        self._along = np.concatenate([group.along for group in groups])
        self._intervals = _intervals(groups, self._first)
        self._airspeed = np.empty(len(self._intervals.edges))
        for side in (
            1,
            0,
        ):  # the left edges last: a shared edge has the airspeed of the block that begins there
            self._airspeed[self._intervals.left + side] = np.repeat(
                [group.airspeed for group in groups], lengths
            )
        residual = np.concatenate([group.residual for group in groups])
        self._data = np.column_stack([np.ones(len(residual)), self._along, residual])

    def of(self, noise: Array) -> float:
        """The restricted log-likelihood (Harville 1974), up to a constant.

        `noise` (3,) is ln(gust deviation [m/s], gust length [m], white deviation [m/s]).
        Raises numpy.linalg.LinAlgError where the legs do not determine airspeed and wind.
        """
        deviation, length, white = np.exp(noise)
        gust = MarkovProcess(deviation, length / self._airspeed, self._along)
        factored = MarkovNoise(
            self._intervals, np.full(len(self._data), white**2 + _FLOOR**2), [gust]
        )
        weighed = factored.weigh(self._data)
        products = np.add.reduceat(self._data[:, :, None] * weighed[:, None, :], self._first)
        scale = np.sqrt(np.diagonal(products, axis1=1, axis2=2))
        factors = np.linalg.cholesky(products / scale[:, :, None] / scale[:, None, :])
        # The last row of a factor holds the residual explained by airspeed and wind; its last
        # element is the rest.
        pivots = np.diagonal(factors, axis1=1, axis2=2) * scale
        log_normal = 2.0 * np.sum(np.log(pivots[:, :-1]))
        return float(-0.5 * (factored.log_determinant + log_normal + np.sum(pivots[:, -1] ** 2)))


def _intervals(groups: Sequence[LinearizedGroup], first: NDArray[np.intp]) -> Intervals:
    """The seconds of all groups in one series, with gaps between groups that no gust correlation
    spans.
    """
    step = np.diff(np.concatenate([group.time for group in groups]))
    step[first[1:] - 1] = _FORGOTTEN
    time = np.concatenate([[0.0], np.cumsum(np.minimum(step, _FORGOTTEN))])
    left = np.concatenate([[0], np.cumsum(np.where(step < _TOUCHING, 1, 2))])
    edges = np.empty(left[-1] + 2)
    edges[left + 1] = time + 0.5 * SECOND
    edges[left] = time - 0.5 * SECOND
    return Intervals(edges, left)


def answer_variances(group: LinearizedGroup, noises: Array) -> Array:
    """Variances of a group's airspeed and wind components [(m/s)²], (m, 3), under noises (m, 3).

    The noise is white noise plus the exact mean of the gust over each second. The group must be
    sorted by time.
    """
    deviation, length, white = np.exp(noises.T)
    a = SECOND * group.airspeed / length
    same, other = 2.0 * (a - 1.0 + np.exp(-a)) / a**2, 2.0 * (np.cosh(a) - 1.0) / a**2
    seen = (
        group.gain[:, :, None] * group.along[:, None, :]
    )  # (n, 3, 2): change of the answer per gust component
    earlier = _remembered(
        seen, np.exp(-a * np.diff(group.time, prepend=group.time[0])[:, None] / SECOND)
    )
    shared = 2.0 * np.einsum("nkc,nmkc->mk", seen, earlier)
    gust = same[:, None] * np.sum(seen**2, axis=(0, 2)) + other[:, None] * shared
    return np.asarray(
        deviation[:, None] ** 2 * gust + white[:, None] ** 2 * np.sum(group.gain**2, axis=0)
    )


def _remembered(seen: Array, decay: Array) -> Array:
    """The sum over all earlier seconds, weighted by their correlation with this one, (n, m, 3, 2).

    `decay` (n, m) is the correlation with the second before. One pass is enough: with an
    exponential correlation each sum follows from the last.
    """
    sums = np.zeros((*decay.shape, *seen.shape[1:]))
    for second in range(1, len(seen)):
        sums[second] = decay[second, :, None, None] * (sums[second - 1] + seen[second - 1])
    return sums


# Fixed-speed GPS methods: one true airspeed and one wind from legs flown at one airspeed. Three
# legs: exact (Gray, National Test Pilot School, 1998). Four legs: the mean of the four three-leg
# answers. Their spread (standard deviation) is a measure of how steady wind and airspeed were.

_ILL_CONDITIONED = 1e6  # condition number: beyond it the tracks are practically the same
_STEPS = 6  # of Gauss-Newton, which converges in three or four


@dataclass(frozen=True, slots=True)
class FixedSpeedResult:
    """True airspeed [m/s] and wind.

    `spread` [m/s] is the standard deviation of the three-leg answers, None for three legs.
    `wind_speed` is in m/s, and `wind_from` the direction from which the wind comes [rad, 0 to 2π].
    """

    true_airspeed: float
    spread: float | None
    wind_speed: float
    wind_from: float


def fixed_speed(ground_speed: MetersPerSecond, track: Radians) -> FixedSpeedResult:
    """Solve three or four legs flown at one true airspeed.

    Parameters: ground speed [m/s] and true track [rad] of each leg, shape (3,) or (4,). Raises
    BadInputError for another number of legs or non-positive speeds, NoAnswerError for tracks that
    are too similar.
    """
    speed, angle = np.asarray(ground_speed, dtype=np.float64), np.asarray(track, dtype=np.float64)
    if speed.shape != angle.shape or speed.shape not in ((3,), (4,)):
        raise BadInputError(
            f"give three or four legs, a speed and a track each; got {speed.size} and {angle.size}"
        )
    if not np.all(np.isfinite(speed) & np.isfinite(angle)) or not np.all(speed > 0.0):
        raise BadInputError("ground speeds must be positive numbers and tracks numbers")
    velocity = np.stack([speed * np.cos(angle), speed * np.sin(angle)], axis=1)
    answers = three_leg_answers(velocity)
    airspeed, north, east = answers.mean(axis=0)
    spread = float(answers[:, 0].std(ddof=1)) if len(answers) > 1 else None
    wind_from = float(np.arctan2(-east, -north) % (2.0 * np.pi))
    return FixedSpeedResult(float(airspeed), spread, float(np.hypot(north, east)), wind_from)


def triples(count: int) -> NDArray[np.intp]:
    """Return the legs of each answer of three among some, (m, 3)."""
    return np.array(list(combinations(range(count), 3)))


def three_leg_answers(velocity: Array) -> Array:
    """Return the true airspeed and the wind north and east, (m, 3) [m/s], of every three ground
    velocities among (n, 2): the circle through their tips.

    Raises NoAnswerError for tracks that are too similar.
    """
    three = velocity[triples(len(velocity))]
    chords, squares = three[:, 1:] - three[:, :1], np.sum(three**2, axis=2)
    if np.any(np.linalg.cond(chords) > _ILL_CONDITIONED):
        raise NoAnswerError("the legs do not determine the wind: fly tracks at least 60° apart")
    wind = np.linalg.solve(chords, 0.5 * (squares[:, 1:] - squares[:, :1])[..., None])[..., 0]
    return np.column_stack([np.linalg.norm(three[:, 0] - wind, axis=1), wind])


def three_leg_gain(velocity: Array) -> Array:
    """Return the change of the mean airspeed of `three_leg_answers` per 1 m/s along the flight path
    in each ground velocity, (n,) [-].
    """
    three, gain = triples(len(velocity)), np.zeros(len(velocity))
    through = velocity[three] - three_leg_answers(velocity)[:, None, 1:]
    unit = through / np.linalg.norm(through, axis=2, keepdims=True)
    jacobian = np.concatenate([np.ones((*three.shape, 1)), unit], axis=2)
    np.add.at(gain, three, np.linalg.inv(jacobian)[:, 0] / len(three))
    return gain


def horseshoe(ground_speed: MetersPerSecond) -> float:
    """True airspeed [m/s] from three legs on ground tracks 90° apart, the middle one second.

    V = ½·sqrt(V1² + V2² + V3² + V1² V3²/V2²); Lowry, Performance of Light Aircraft, 1999. The
    formula is exact for tracks. Where headings are held instead, a wind w along the middle leg
    makes the answer w²/V too high. Raises BadInputError for ground speeds that are not positive.
    """
    first, second, third = (float(v) for v in ground_speed)
    if min(first, second, third) <= 0.0:
        raise BadInputError("ground speeds must be positive")
    return 0.5 * float(np.sqrt(first**2 + second**2 + third**2 + (first * third / second) ** 2))


def circle_fit(velocity: Array) -> Array:
    """Fit a circle to ground velocities (n, 2) at one airspeed: true airspeed and wind [V, W_N,
    W_E] [m/s].

    Least squares of the distances from the circle, by Gauss-Newton from the algebraic fit (Kåsa
    1976). Raises NoAnswerError where the velocities are too similar.
    """
    columns = np.column_stack([2.0 * velocity, np.ones(len(velocity))])
    if len(velocity) < 3 or np.linalg.cond(columns) > _ILL_CONDITIONED:
        raise NoAnswerError("the turn does not determine the wind: fly a full one")
    north, east, rest = np.linalg.lstsq(columns, np.sum(velocity**2, axis=1))[0]
    answer = np.array([np.sqrt(rest + north**2 + east**2), north, east])
    for _ in range(_STEPS):
        through_air = velocity - answer[1:]
        distance = np.linalg.norm(through_air, axis=1)
        jacobian = np.column_stack([np.ones(len(velocity)), through_air / distance[:, None]])
        answer = answer + np.linalg.lstsq(jacobian, distance - answer[0])[0]
    return answer


def circle_gain(velocity: Array, answer: Array) -> Array:
    """Change of the answer of `circle_fit` per 1 m/s along the flight path in each ground velocity,
    (n, 3) [-].

    Parameters: velocity (n, 2) [m/s]; answer [V, W_N, W_E] [m/s]. By the implicit function theorem:
    the gradient of the fit, the sum of r (1, u) with residuals r and unit vectors u of the flight
    path, remains zero. A step along u changes r alone.
    """
    through_air = velocity - answer[1:]
    distance = np.linalg.norm(through_air, axis=1)
    unit = through_air / distance[:, None]
    jacobian = np.column_stack([np.ones(len(velocity)), unit])
    curvature = jacobian.T @ jacobian
    bend = (distance - answer[0]) / distance  # the residuals turn the unit vectors a little
    curvature[1:, 1:] += bend.sum() * np.eye(2) - (unit * bend[:, None]).T @ unit
    return np.linalg.solve(curvature, jacobian.T).T


# Fixed-speed points from a log: each group of steady legs or turn gives one airspeed, wind and
# correction. The indicated airspeed varies a little within a group. The difference of the indicated
# true airspeed from the group's mean is subtracted from each ground velocity, along the flight
# path. Then the methods' formulas apply as published.

_METHODS = {3: "three_leg", 4: "four_leg"}
_ROUNDS = (
    4  # the subtracted speed depends on the flight path, and this on the wind: it settles at once
)
_STEP = 0.01  # m/s, for the numerical derivatives of an answer with respect to each leg
_RIGHT_ANGLE_OFF = 2.0 * DEGREE  # the test card's tolerance on heading


@dataclass(frozen=True, slots=True)
class _Solved:
    """A group with its answer [V, W_N, W_E] [m/s].

    `velocity` (n, 2) [m/s] is brought to one airspeed; `spread` [m/s] is the standard deviation of
    the three-leg answers of four legs, or of the residual for a turn and for more legs.
    """

    group: SteadyGroup
    method: str
    velocity: Array
    answer: Array
    spread: float | None
    linearized: "LinearizedGroup"


def fixed_speed_points(
    log: FlightLog,
    options: CalibrationOptions | None = None,
    location: LikelyLocation | None = None,
) -> tuple[FixedSpeedPoint, ...]:
    """One point for each full turn and each group of legs on three or more tracks at one airspeed.

    `location` is that of the error, where a fit has found it; else it is judged as a fit of the
    curve does. The used options are the row selection, the recovery factor, the error location and
    the accuracies (stated, else the header's, else the usual ones). The 2σ covers gusts, sensor
    noise and GPS noise as found in the log, and the accuracies. Raises BadInputError for a log that
    cannot be used, NoAnswerError for one without such legs or turns.
    """
    with one_thread():
        return _points(log, options or CalibrationOptions(), location)


def _points(
    log: FlightLog, options: CalibrationOptions, location: LikelyLocation | None
) -> tuple[FixedSpeedPoint, ...]:
    obs = observe(log, options)
    solved = [_solve(group) for group in steady_groups(log, obs)]
    if not solved:
        raise NoAnswerError(
            "no fixed-speed point in this log: no full turn, and no three steady legs at one "
            "airspeed and height; "
            "fly four legs 90° apart, at least 5 s each, or a full turn at constant bank"
        )
    bounds = two_sigma([one.linearized for one in solved])
    answers = [
        pair
        for one, bound in zip(solved, bounds, strict=True)
        for pair in ((one, bound), *_horseshoe(one, bound))
    ]
    stated = accuracies_of(options.accuracies, log.header)
    place = location or likely_location(log, options)
    return tuple(_located_point(each, bound, obs, stated, place) for each, bound in answers)


def _located_point(
    each: _Solved, bound: Array, obs: Observations, stated: Accuracies, place: LikelyLocation
) -> FixedSpeedPoint:
    """The point, with the doubt about the location of the error in its correction and its bound."""
    here, there = (
        _point(each, bound, leg_air(each.group, obs, static), stated) for static in (True, False)
    )
    apart = here.correction - there.correction
    correction = there.correction + place.static * apart
    return replace(
        here if place.static >= 0.5 else there,
        calibrated_airspeed=here.indicated_airspeed + correction,
        correction=correction,
        two_sigma=float(
            np.hypot((here if place.static >= 0.5 else there).two_sigma, 2.0 * place.doubt * apart)
        ),
    )


def cross_check(
    log: FlightLog, options: CalibrationOptions | None = None, found: Calibration | None = None
) -> tuple[FixedSpeedPoint, ...]:
    """The fixed-speed points to compare a curve with; none where the log has no such legs or turns.

    The location of the error is that of the curve's calibration, where it is given.
    """
    chosen = options or CalibrationOptions()
    location = None
    if found is not None:
        location = location_of(chosen, found.error_location, found.diagnostics.static_probability)
    try:
        return fixed_speed_points(log, chosen, location)
    except NoAnswerError:
        return ()


def _solve(group: SteadyGroup) -> _Solved:
    blocks = group.blocks
    airspeed = blocks.indicated_true_airspeed
    off = airspeed - group.leg_means(airspeed).mean()
    velocity, answer, spread = blocks.velocity, np.zeros(3), None
    for _ in range(_ROUNDS):
        velocity = blocks.velocity - off[:, None] * _direction(blocks.velocity, answer)
        answer, spread = _answer(group, velocity)
    along = _direction(velocity, answer)
    rest = np.linalg.norm(velocity - answer[1:], axis=1) - answer[0]
    if group.turning or group.legs > 4:
        spread = float(rest.std(ddof=3))
    gain = circle_gain(velocity, answer) if group.turning else _leg_gain(group, velocity, along)
    method = "turn" if group.turning else _METHODS.get(group.legs, "many_leg")
    problem = LinearizedGroup(blocks.time, rest, along, gain, float(answer[0]))
    return _Solved(group, method, velocity, answer, spread, problem)


def _horseshoe(one: _Solved, bound: Array) -> list[tuple[_Solved, Array]]:
    """The answer of the horseshoe method, in addition to that of three legs, for tracks nearly 90°
    apart.

    The tracks are not exactly 90° apart, so the formula has an error. It is the difference from the
    three-leg answer and widens the bound.
    """
    if one.method != "three_leg":
        return []
    mean = one.group.leg_means(one.velocity)
    track = np.arctan2(mean[:, 1], mean[:, 0])
    for middle in range(3):
        first, last = (other for other in range(3) if other != middle)
        turns = [
            (track[other] - track[middle] + np.pi) % (2.0 * np.pi) - np.pi
            for other in (first, last)
        ]
        if (
            turns[0] * turns[1] < 0.0
            and max(abs(abs(turn) - 0.5 * np.pi) for turn in turns) < _RIGHT_ANGLE_OFF
        ):
            airspeed = horseshoe(np.linalg.norm(mean[[first, middle, last]], axis=1))
            off = np.array([abs(airspeed - one.answer[0]), 0.0, 0.0])
            return [
                (
                    replace(one, method="horseshoe", answer=np.array([airspeed, *one.answer[1:]])),
                    bound + off,
                )
            ]
    return []


def _leg_gain(group: SteadyGroup, velocity: Array, along: Array) -> Array:
    """Change of the answer per 1 m/s along the flight path in each second, (n, 3) [-].

    The answer depends on the means of the legs alone, so these are changed one after the other.
    """
    mean = group.leg_means(velocity)
    slope = np.empty((*mean.shape, 3))
    for place in np.ndindex(mean.shape):
        ahead, behind = mean.copy(), mean.copy()
        ahead[place] += _STEP
        behind[place] -= _STEP
        slope[place] = (_answer_of_legs(ahead)[0] - _answer_of_legs(behind)[0]) / (2.0 * _STEP)
    share = along / np.bincount(group.leg)[group.leg][:, None]
    return np.asarray(np.einsum("nc,nck->nk", share, slope[group.leg]))


def _direction(velocity: Array, answer: Array) -> Array:
    through_air = velocity - answer[1:]
    return np.asarray(through_air / np.linalg.norm(through_air, axis=1, keepdims=True))


def _answer(group: SteadyGroup, velocity: Array) -> tuple[Array, float | None]:
    """Airspeed and wind [V, W_N, W_E] by the method that fits the group, and the spread of
    three-leg answers.
    """
    return (
        (circle_fit(velocity), None)
        if group.turning
        else _answer_of_legs(group.leg_means(velocity))
    )


def _answer_of_legs(mean: Array) -> tuple[Array, float | None]:
    """The same for the mean ground velocities of legs, (k, 2)."""
    if len(mean) > 4:
        return circle_fit(mean), None
    found = fixed_speed(np.linalg.norm(mean, axis=1), np.arctan2(mean[:, 1], mean[:, 0]))
    toward = found.wind_from + np.pi
    wind = found.wind_speed * np.array([np.cos(toward), np.sin(toward)])
    return np.array([found.true_airspeed, *wind]), found.spread


def _point(one: _Solved, bound: Array, here: LegAir, stated: Accuracies) -> FixedSpeedPoint:
    true = float(one.answer[0])
    calibrated = here.calibrated_airspeed(true)
    slope = (here.calibrated_airspeed(true + _STEP) - calibrated) / _STEP
    return FixedSpeedPoint(
        method=one.method,
        legs=one.group.legs,
        seconds=len(one.group.blocks) * SECOND,
        indicated_airspeed=here.indicated_airspeed,
        calibrated_airspeed=calibrated,
        correction=calibrated - here.indicated_airspeed,
        two_sigma=float(np.hypot(slope * bound[0], here.stated_two_sigma(true, stated))),
        true_airspeed=true,
        true_airspeed_two_sigma=float(bound[0]),
        spread=one.spread,
        wind_north=float(one.answer[1]),
        wind_east=float(one.answer[2]),
        wind_two_sigma=float(np.hypot(bound[1:].max(), stated.velocity_mps)),
    )
