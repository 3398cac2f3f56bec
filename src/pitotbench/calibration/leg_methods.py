"""Fixed-speed methods: one true airspeed and one wind from legs or a turn at one airspeed."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibration.leg_air import LegAir
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.units import DEGREE, Array, MetersPerSecond, Radians, Seconds

# Three legs: exact (Gray, National Test Pilot School, 1998). Four legs: the mean of the four
# three-leg answers. Their spread (standard deviation) is a measure of how steady wind and airspeed
# were. A turn and more legs: a circle.

_ILL_CONDITIONED = 1e6  # condition number: beyond it the tracks are practically the same
_STEPS = 6  # of Gauss-Newton, which converges in three or four
_METHODS = {3: "three_leg", 4: "four_leg"}
_ROUNDS, _SETTLED = 40, 1e-9  # at most; m/s
_SAME_TRACK = 30.0 * DEGREE  # pieces whose tracks differ by less are one leg
_RIGHT_ANGLE_OFF = 2.0 * DEGREE  # the test card's tolerance on heading


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
    (airspeed, *wind), spread = answer_of_legs(velocity)
    return FixedSpeedResult(float(airspeed), spread, float(np.hypot(*wind)), wind_from(wind))


def wind_from(wind: Array | list[float]) -> float:
    """Return the direction from which a wind (north, east) comes [rad, 0 to 2π]."""
    return float(np.arctan2(-wind[1], -wind[0]) % (2.0 * np.pi))


def answer_of_legs(velocity: Array) -> tuple[Array, float | None]:
    """Return [V, W_N, W_E] [m/s] of the ground velocities of legs, (n, 2), by the method of their
    number, and the spread of the answers of three among four.
    """
    if len(velocity) > max(_METHODS):
        return circle_fit(velocity), None
    answers = _three_leg_answers(velocity)
    spread = float(answers[:, 0].std(ddof=1)) if len(answers) > 1 else None
    return answers.mean(axis=0), spread


def _triples(count: int) -> NDArray[np.intp]:
    """The legs of each answer of three among some, (m, 3)."""
    return np.array(list(combinations(range(count), 3)))


def _three_leg_answers(velocity: Array) -> Array:
    """Return the true airspeed and the wind north and east, (m, 3) [m/s], of every three ground
    velocities among (n, 2): the circle through their tips.

    Raises NoAnswerError for tracks that are too similar.
    """
    three = velocity[_triples(len(velocity))]
    chords, squares = three[:, 1:] - three[:, :1], np.sum(three**2, axis=2)
    if np.any(np.linalg.cond(chords) > _ILL_CONDITIONED):
        raise NoAnswerError("the legs do not determine the wind: fly tracks at least 60° apart")
    wind = np.linalg.solve(chords, 0.5 * (squares[:, 1:] - squares[:, :1])[..., None])[..., 0]
    return np.column_stack([np.linalg.norm(three[:, 0] - wind, axis=1), wind])


def leg_gain(velocity: Array, answer: Array) -> Array:
    """Change of the answer of `answer_of_legs` per 1 m/s along the flight path in each ground
    velocity, (n, 3) [-].
    """
    if len(velocity) > max(_METHODS):
        return circle_gain(velocity, answer)
    three, gain = _triples(len(velocity)), np.zeros((len(velocity), 3))
    along = direction(velocity[three], _three_leg_answers(velocity)[:, None, 1:])
    jacobian = np.concatenate([np.ones((*three.shape, 1)), along], axis=2)
    np.add.at(gain, three, np.swapaxes(np.linalg.inv(jacobian), 1, 2) / len(three))
    return gain


def direction(velocity: Array, wind: Array) -> Array:
    """Return the unit vectors of the flight path, (..., 2), for ground velocities and a wind."""
    through_air = velocity - wind
    return np.asarray(through_air / np.linalg.norm(through_air, axis=-1, keepdims=True))


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


def horseshoe_of_legs(velocity: Array) -> float | None:
    """The true airspeed [m/s] by the horseshoe, of the ground velocities of three legs (3, 2) whose
    tracks are nearly 90° apart; None for others.
    """
    track = np.arctan2(velocity[:, 1], velocity[:, 0])
    for middle in range(3):
        sides = [other for other in range(3) if other != middle]
        turns = (track[sides] - track[middle] + np.pi) % (2.0 * np.pi) - np.pi
        if np.prod(turns) < 0.0 and np.all(np.abs(np.abs(turns) - 0.5 * np.pi) < _RIGHT_ANGLE_OFF):
            order = [sides[0], middle, sides[1]]
            return horseshoe(np.linalg.norm(velocity[order], axis=1))
    return None


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
        left = np.linalg.norm(velocity - answer[1:], axis=1) - answer[0]
        jacobian = np.column_stack([np.ones(len(velocity)), direction(velocity, answer[1:])])
        answer = answer + np.linalg.lstsq(jacobian, left)[0]
    return answer


def circle_gain(velocity: Array, answer: Array) -> Array:
    """Change of the answer of `circle_fit` per 1 m/s along the flight path in each ground velocity,
    (n, 3) [-].

    Parameters: velocity (n, 2) [m/s]; answer [V, W_N, W_E] [m/s]. By the implicit function theorem:
    the gradient of the fit, the sum of r (1, u) with residuals r and unit vectors u of the flight
    path, remains zero. A step along u changes r alone.
    """
    along = direction(velocity, answer[1:])
    distance = np.linalg.norm(velocity - answer[1:], axis=1)
    jacobian = np.column_stack([np.ones(len(velocity)), along])
    curvature = jacobian.T @ jacobian
    bend = (distance - answer[0]) / distance  # the residuals turn the unit vectors a little
    curvature[1:, 1:] += bend.sum() * np.eye(2) - (along * bend[:, None]).T @ along
    return np.linalg.solve(curvature, jacobian.T).T


# Legs of a log, a second a row, and legs of a card, a leg a row, are one problem. The airspeed
# varies a little within a group. The difference of the indicated true airspeed from the group's
# mean is subtracted from each ground velocity, along the flight path. Then the methods' formulas
# apply as published.


def by_track(track: Radians) -> NDArray[np.intp]:
    """Return the numbers of the legs, (n,), of pieces on tracks (n,): pieces on one track are one
    leg, and the legs are numbered by track.
    """
    order = np.argsort(track)
    leg = np.empty(len(track), dtype=np.intp)
    leg[order] = np.concatenate([[0], np.cumsum(np.diff(track[order]) > _SAME_TRACK)])
    if track[order[0]] + 2.0 * np.pi - track[order[-1]] <= _SAME_TRACK:  # on both sides of south
        leg[leg == leg.max()] = 0
    return leg


def means_by_leg(data: Array, leg: NDArray[np.intp]) -> Array:
    """Means of (n,) or (n, k) data over each leg, (legs,) or (legs, k)."""
    return np.stack([data[leg == number].mean(axis=0) for number in range(int(leg.max()) + 1)])


@dataclass(frozen=True, slots=True)
class LegGroup:
    """Rows (n,) flown at about one airspeed, in the order of `time`: seconds of a log, or legs of a
    card.

    `air` is the mean air, `airspeed` [m/s] the indicated true airspeed of each row. `toward` (n, 2)
    is the unit vector of the track, or of the heading where `by_heading`. `leg` is the number of
    each row's leg; a turn is one leg.
    """

    air: LegAir
    time: Seconds
    airspeed: MetersPerSecond
    ground_speed: MetersPerSecond
    toward: Array
    by_heading: NDArray[np.bool_]
    leg: NDArray[np.intp]
    turning: bool = False

    @property
    def legs(self) -> int:
        """The number of legs."""
        return int(self.leg.max()) + 1

    def leg_means(self, data: Array) -> Array:
        """Means of (n,) or (n, k) data over each leg, (legs,) or (legs, k)."""
        return means_by_leg(data, self.leg)


@dataclass(frozen=True, slots=True)
class SolvedGroup:
    """A group with its answer [V, W_N, W_E] [m/s].

    `velocity` (n, 2) [m/s] is brought to one airspeed, `along` (n, 2) the flight path, `residual`
    (n,) [m/s] that of ground velocity against airspeed and wind. `gain` (n, 3) is the change of the
    answer per residual of each row [-]. `spread` [m/s] is the standard deviation of the three-leg
    answers of four legs, or of the residual for a turn and for more legs.
    """

    group: LegGroup
    method: str
    velocity: Array
    answer: Array
    spread: float | None
    along: Array
    residual: Array
    gain: Array


def solve_group(group: LegGroup) -> SolvedGroup:
    """Solve a group by the method of its number of legs. Raises NoAnswerError for tracks that do
    not determine the wind.
    """
    off = (group.airspeed - group.air.true_airspeed())[:, None]
    velocity = group.ground_speed[:, None] * group.toward
    answer, spread = np.array([float(group.airspeed.mean()), 0.0, 0.0]), None
    for _ in range(_ROUNDS):
        drifted = (answer[0] + off) * group.toward + answer[1:]
        path = np.where(
            group.by_heading[:, None], direction(drifted, 0.0 * answer[1:]), group.toward
        )
        moved = group.ground_speed[:, None] * path
        velocity = moved - off * direction(moved, answer[1:])
        before = answer
        answer, spread = (
            (circle_fit(velocity), None)
            if group.turning
            else answer_of_legs(group.leg_means(velocity))
        )
        if np.max(np.abs(answer - before)) < _SETTLED:
            break
    along = direction(velocity, answer[1:])
    residual = np.linalg.norm(velocity - answer[1:], axis=1) - answer[0]
    if group.turning:
        method, gain = "turn", circle_gain(velocity, answer)
    else:
        method, legs = _METHODS.get(group.legs, "many_leg"), group.leg_means(velocity)
        share = np.sum(along * direction(legs, answer[1:])[group.leg], axis=1)
        share = share / np.bincount(group.leg)[group.leg]
        gain = share[:, None] * leg_gain(legs, answer)[group.leg]
    if group.turning or group.legs > max(_METHODS):
        spread = float(residual.std(ddof=3))
    return SolvedGroup(group, method, velocity, answer, spread, along, residual, gain)
