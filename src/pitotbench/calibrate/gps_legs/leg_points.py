"""Fixed-speed points from a log: each group of steady legs or turn gives one airspeed, wind and correction.

The indicated airspeed varies a little within a group. The difference of the indicated true airspeed from the
group's mean is subtracted from each ground velocity, along the flight path. Then the methods' formulas apply as
published.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from pitotbench.calibrate.accuracy import Accuracies, accuracies_of
from pitotbench.calibrate.gps_legs.leg_air import LegAir, leg_air
from pitotbench.calibrate.gps_legs.legs import SteadyGroup, steady_groups
from pitotbench.calibrate.gps_legs.likely_location import LikelyLocation, likely_location, location_of
from pitotbench.calibrate.gps_legs.methods import circle_fit, circle_gain, fixed_speed, horseshoe
from pitotbench.calibrate.one_thread import one_thread
from pitotbench.calibrate.options import CalibrationOptions
from pitotbench.calibrate.rows.observations import Observations, observe
from pitotbench.calibrate.rows.steady_blocks import SECOND
from pitotbench.records.calibration import Calibration
from pitotbench.records.errors import NoAnswerError
from pitotbench.records.fixed_speed_point import FixedSpeedPoint
from pitotbench.records.log import FlightLog
from pitotbench.units import DEGREE, Array

if TYPE_CHECKING:
    from pitotbench.calibrate.gps_legs.leg_noise import LinearizedGroup

_METHODS = {3: "three_leg", 4: "four_leg"}
_ROUNDS = 4  # the subtracted speed depends on the flight path, and this on the wind: it settles at once
_STEP = 0.01  # m/s, for the numerical derivatives of an answer with respect to each leg
_RIGHT_ANGLE_OFF = 2.0 * DEGREE  # the test card's tolerance on heading


@dataclass(frozen=True, slots=True)
class _Solved:
    """A group with its answer [V, W_N, W_E] [m/s].

    `velocity` (n, 2) [m/s] is brought to one airspeed; `spread` [m/s] is the standard deviation of the
    three-leg answers of four legs, or of the residual for a turn and for more legs.
    """

    group: SteadyGroup
    method: str
    velocity: Array
    answer: Array
    spread: float | None
    linearized: "LinearizedGroup"


def fixed_speed_points(
    log: FlightLog, options: CalibrationOptions | None = None, location: LikelyLocation | None = None
) -> tuple[FixedSpeedPoint, ...]:
    """One point for each full turn and each group of legs on three or more tracks at one airspeed.

    `location` is that of the error, where a fit has found it; else it is judged as a fit of the curve does.
    The used options are the row selection, the recovery factor, the error location and the accuracies (stated, else
    the header's, else the usual ones). The 2σ covers gusts, sensor noise and GPS noise as found in the log, and the
    accuracies.
    Raises BadInputError for a log that cannot be used, NoAnswerError for one without such legs or turns.
    """
    with one_thread():
        return _points(log, options or CalibrationOptions(), location)


def _points(
    log: FlightLog, options: CalibrationOptions, location: LikelyLocation | None
) -> tuple[FixedSpeedPoint, ...]:
    from pitotbench.calibrate.gps_legs.leg_noise import two_sigma  # SciPy loads with it

    obs = observe(log, options)
    solved = [_solve(group) for group in steady_groups(log, obs)]
    if not solved:
        raise NoAnswerError(
            "no fixed-speed point in this log: no full turn, and no three steady legs at one airspeed and height; "
            "fly four legs 90° apart, at least 5 s each, or a full turn at constant bank"
        )
    bounds = two_sigma([one.linearized for one in solved])
    answers = [
        pair for one, bound in zip(solved, bounds, strict=True) for pair in ((one, bound), *_horseshoe(one, bound))
    ]
    stated = accuracies_of(options.accuracies, log.header)
    place = location or likely_location(log, options)
    return tuple(_located_point(each, bound, obs, stated, place) for each, bound in answers)


def _located_point(
    each: _Solved, bound: Array, obs: Observations, stated: Accuracies, place: LikelyLocation
) -> FixedSpeedPoint:
    """The point, with the doubt about the location of the error in its correction and its bound."""
    here, there = (_point(each, bound, leg_air(each.group, obs, static), stated) for static in (True, False))
    apart = here.correction - there.correction
    correction = there.correction + place.static * apart
    return replace(
        here if place.static >= 0.5 else there,
        calibrated_airspeed=here.indicated_airspeed + correction,
        correction=correction,
        two_sigma=float(np.hypot((here if place.static >= 0.5 else there).two_sigma, 2.0 * place.doubt * apart)),
    )


def cross_check(
    log: FlightLog, options: CalibrationOptions | None = None, found: Calibration | None = None
) -> tuple[FixedSpeedPoint, ...]:
    """The fixed-speed points to compare a curve with; none where the log has no such legs or turns.

    The location of the error is that of the curve's calibration, where it is given.
    """
    chosen = options or CalibrationOptions()
    location = None if found is None else location_of(chosen, found.error_location, found.diagnostics or {})
    try:
        return fixed_speed_points(log, chosen, location)
    except NoAnswerError:
        return ()


def _solve(group: SteadyGroup) -> _Solved:
    from pitotbench.calibrate.gps_legs.leg_noise import LinearizedGroup  # SciPy loads with it

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
    """The answer of the horseshoe method, in addition to that of three legs, for tracks nearly 90° apart.

    The tracks are not exactly 90° apart, so the formula has an error. It is the difference from the three-leg
    answer and widens the bound.
    """
    if one.method != "three_leg":
        return []
    mean = one.group.leg_means(one.velocity)
    track = np.arctan2(mean[:, 1], mean[:, 0])
    for middle in range(3):
        first, last = (other for other in range(3) if other != middle)
        turns = [(track[other] - track[middle] + np.pi) % (2.0 * np.pi) - np.pi for other in (first, last)]
        if turns[0] * turns[1] < 0.0 and max(abs(abs(turn) - 0.5 * np.pi) for turn in turns) < _RIGHT_ANGLE_OFF:
            airspeed = horseshoe(np.linalg.norm(mean[[first, middle, last]], axis=1))
            off = np.array([abs(airspeed - one.answer[0]), 0.0, 0.0])
            return [(replace(one, method="horseshoe", answer=np.array([airspeed, *one.answer[1:]])), bound + off)]
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
    """Airspeed and wind [V, W_N, W_E] by the method that fits the group, and the spread of three-leg answers."""
    return (circle_fit(velocity), None) if group.turning else _answer_of_legs(group.leg_means(velocity))


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
