"""Fixed-speed GPS methods: one true airspeed and one wind from legs flown at one airspeed.

Three legs: exact (Gray, National Test Pilot School, 1998). Four legs: the mean of the four three-leg answers.
Their spread (standard deviation) is a measure of how steady wind and airspeed were.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.units import Array, MetersPerSecond, Radians

_ILL_CONDITIONED = 1e6  # condition number: beyond it the tracks are practically the same
_STEPS = 6  # of Gauss-Newton, which converges in three or four


@dataclass(frozen=True, slots=True)
class FixedSpeedResult:
    """True airspeed [m/s] and wind.

    `spread` [m/s] is the standard deviation of the three-leg answers, None for three legs. `wind_speed` is in m/s,
    and `wind_from` the direction from which the wind comes [rad, 0 to 2π].
    """

    true_airspeed: float
    spread: float | None
    wind_speed: float
    wind_from: float


def fixed_speed(ground_speed: MetersPerSecond, track: Radians) -> FixedSpeedResult:
    """Solve three or four legs flown at one true airspeed.

    Parameters: ground speed [m/s] and true track [rad] of each leg, shape (3,) or (4,).
    Raises BadInputError for another number of legs or non-positive speeds, NoAnswerError for tracks that
    are too similar.
    """
    speed, angle = np.asarray(ground_speed, dtype=np.float64), np.asarray(track, dtype=np.float64)
    if speed.shape != angle.shape or speed.shape not in ((3,), (4,)):
        raise BadInputError(f"give three or four legs, a speed and a track each; got {speed.size} and {angle.size}")
    if not np.all(np.isfinite(speed) & np.isfinite(angle)) or not np.all(speed > 0.0):
        raise BadInputError("ground speeds must be positive numbers and tracks numbers")
    velocity = np.stack([speed * np.cos(angle), speed * np.sin(angle)], axis=1)
    answers = np.array([_three_legs(velocity[list(legs)]) for legs in combinations(range(len(speed)), 3)])
    airspeed, north, east = answers.mean(axis=0)
    spread = float(answers[:, 0].std(ddof=1)) if len(answers) > 1 else None
    wind_from = float(np.arctan2(-east, -north) % (2.0 * np.pi))
    return FixedSpeedResult(float(airspeed), spread, float(np.hypot(north, east)), wind_from)


def _three_legs(velocity: Array) -> tuple[float, float, float]:
    """True airspeed and wind north, east of three ground velocities (3, 2): the circle through their tips."""
    chords = velocity[1:] - velocity[0]
    squares = np.sum(velocity**2, axis=1)
    if np.linalg.cond(chords) > _ILL_CONDITIONED:
        raise NoAnswerError("the legs do not determine the wind: fly tracks at least 60° apart")
    wind = np.linalg.solve(chords, 0.5 * (squares[1:] - squares[0]))
    return float(np.linalg.norm(velocity[0] - wind)), float(wind[0]), float(wind[1])


def horseshoe(ground_speed: MetersPerSecond) -> float:
    """True airspeed [m/s] from three legs on ground tracks 90° apart, the middle one second.

    V = ½·sqrt(V1² + V2² + V3² + V1² V3²/V2²); Lowry, Performance of Light Aircraft, 1999. The formula is exact for
    tracks. Where headings are held instead, a wind w along the middle leg makes the answer w²/V too high.
    Raises BadInputError for ground speeds that are not positive.
    """
    first, second, third = (float(v) for v in ground_speed)
    if min(first, second, third) <= 0.0:
        raise BadInputError("ground speeds must be positive")
    return 0.5 * float(np.sqrt(first**2 + second**2 + third**2 + (first * third / second) ** 2))


def circle_fit(velocity: Array) -> Array:
    """Fit a circle to ground velocities (n, 2) at one airspeed: true airspeed and wind [V, W_N, W_E] [m/s].

    Least squares of the distances from the circle, by Gauss-Newton from the algebraic fit (Kåsa 1976).
    Raises NoAnswerError where the velocities are too similar.
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
    """Change of the answer of `circle_fit` per 1 m/s along the flight path in each ground velocity, (n, 3) [-].

    Parameters: velocity (n, 2) [m/s]; answer [V, W_N, W_E] [m/s]. By the implicit function theorem: the gradient of
    the fit, the sum of r (1, u) with residuals r and unit vectors u of the flight path, remains zero. A step along
    u changes r alone.
    """
    through_air = velocity - answer[1:]
    distance = np.linalg.norm(through_air, axis=1)
    unit = through_air / distance[:, None]
    jacobian = np.column_stack([np.ones(len(velocity)), unit])
    curvature = jacobian.T @ jacobian
    bend = (distance - answer[0]) / distance  # the residuals turn the unit vectors a little
    curvature[1:, 1:] += bend.sum() * np.eye(2) - (unit * bend[:, None]).T @ unit
    return np.linalg.solve(curvature, jacobian.T).T
