"""Fixed-speed points from steady legs and turns of a log: airspeed, wind, correction, bounds."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibration.covering_problem import WHITE_FLOOR, WindNoise, wind_log_prior
from pitotbench.calibration.leg_methods import (
    LegAir,
    Legs,
    SolvedGroup,
    by_track,
    solve_group,
    unit,
)
from pitotbench.calibration.location import STATIC, assumed_location
from pitotbench.calibration.observations import Blocks, Observations, intervals_of, observe
from pitotbench.calibration.options import (
    AUTO,
    PRIORS,
    Accuracies,
    CalibrationOptions,
    Priors,
    accuracies_of,
    priors_of,
)
from pitotbench.calibration.reduction import Reduction, one_thread, reduce_log
from pitotbench.calibration.screening import SECOND
from pitotbench.estimation.mixture import half_width
from pitotbench.estimation.restricted_likelihood import Regression, weighted_noises
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import Calibration
from pitotbench.records.legs import FixedSpeedPoint
from pitotbench.records.log import FlightLog
from pitotbench.timeline import interval
from pitotbench.units import DEGREE, KNOT, Array

_WHOLE = 0.8  # share of a block's rows that must be present


def labeled(log: FlightLog) -> bool:
    """Whether the log marks any row as on condition."""
    return log.on_condition is not None and bool(log.on_condition.any())


def block_means(log: FlightLog, obs: Observations) -> Legs:
    """Average the log's rows in seconds; where the log marks rows as on condition, those alone.

    A run is a piece, and begins with a whole second; incomplete seconds are left out. `time` [s]
    is that of the block, a whole number: the runs move by a second each, so that none meet.
    """
    run = _runs(log, obs)
    flown = obs.at(run >= 0)
    _, begins, run = np.unique(run[run >= 0], return_index=True, return_inverse=True)
    start = flown.time[begins][run]
    ahead = np.floor(start - obs.time[0]) + run
    # Only seconds that have rows are formed: with one wrong time stamp, all up to the last would
    # fill the memory.
    cell, first, index, count = np.unique(
        np.floor((flown.time - start) / SECOND + 1e-6) + ahead,
        return_index=True,
        return_inverse=True,
        return_counts=True,
    )
    blocks = Blocks(
        index, count.astype(np.float64), intervals_of(cell.astype(np.intp), SECOND), SECOND
    )
    whole = np.flatnonzero(count >= _WHOLE * SECOND / interval(obs.time))
    north, east = flown.velocity_north, flown.velocity_east
    # The mean of a turning vector is too short.
    channels = blocks.mean(
        np.column_stack(
            [
                flown.impact_pressure,
                flown.static_pressure,
                flown.probe_temperature,
                np.hypot(north, east),
                north,
                east,
            ]
        )
    )[whole]
    impact, pressure, temperature, speed = channels.T[:4]
    return Legs(
        LegAir(impact, pressure, temperature, obs.probe_heating, standard_day=obs.standard_day),
        cell[whole] * SECOND,
        speed,
        unit(channels[:, 4:]),
        np.zeros(len(whole), dtype=np.bool_),
        run[first[whole]],
    )


def _runs(log: FlightLog, obs: Observations) -> NDArray[np.intp]:
    """The number of each row's run; −1 where the row is not on condition.

    A run is a segment without its rows off condition. In a log without segments it is an
    uninterrupted stretch on condition.
    """
    on = np.ones(len(obs), dtype=np.bool_)
    if log.on_condition is not None and labeled(log):
        on = log.on_condition[obs.used]
    segment = on if log.segment is None else log.segment[obs.used]
    changed = (np.diff(obs.stretch) != 0) | (segment[1:] != segment[:-1])
    return np.where(on, np.concatenate([[0], np.cumsum(changed)]), -1)


# Where the log marks what was on condition, the marks are used. Else straight legs and turns are
# found from the ground velocity, which gusts change less than the air data. In both cases a piece
# must be long enough, straight or a full turn, level, and of constant airspeed.

# s, the least on condition that Martos, Kiszely and Foster (2011), III.A, allow a leg
_SHORTEST = 5.0
_STRAIGHT = 5.0 * DEGREE  # largest change of mean track between the halves of a straight leg
# Least change of track of a turn: the ground velocities of a smaller one are only an arc.
_FULL_TURN = 300.0 * DEGREE
# rad/s: straight flight below, a third of a standard-rate turn above (no labels)
_TURN_RATE = 1.0 * DEGREE
# m/s² of ground speed: above it the airspeed is being changed (no labels)
_ACCELERATION = 0.5 * KNOT
_WINDOW = 2  # blocks to either side, for rates of change (no labels)
# Limits between the halves of a piece: m/s of airspeed, and a share of the static pressure, about
# 300 ft.
_DRIFT = 3.0 * KNOT
_LEVEL = 0.01
_ALIKE = 1.3  # times these: the mean difference between the legs of a group, at most


def steady_groups(log: FlightLog, obs: Observations) -> tuple[Legs, ...]:
    """Find full turns, and groups of straight legs on three tracks or more, sorted by airspeed."""
    blocks = block_means(log, obs)
    if not labeled(log):
        blocks = _stretches(blocks)
    long = [p for p in blocks.pieces() if len(p.time) * SECOND >= _SHORTEST and _holds(p)]
    turns = [
        replace(piece, leg=np.arange(len(piece.leg)), turning=True)
        for piece in long
        if np.ptp(piece.track) >= _FULL_TURN
    ]
    straight = [
        piece for piece in long if abs(float(np.diff(_halves(piece.track))[0])) <= _STRAIGHT
    ]
    return tuple(sorted([*turns, *_groups(blocks, straight)], key=_airspeed))


def _groups(blocks: Legs, pieces: list[Legs]) -> list[Legs]:
    """Join pieces of the blocks at one airspeed and height to groups of legs.

    A group has three tracks or more, and its pieces differ little in the mean.
    """
    if len(pieces) < 3:
        return []
    from scipy.cluster.hierarchy import fclusterdata  # slow to load

    heights = [float(np.log(piece.air.static_pressure.mean())) for piece in pieces]
    flown = np.column_stack([[_airspeed(piece) / _DRIFT for piece in pieces], heights])
    flown[:, 1] /= _LEVEL
    group = fclusterdata(flown, _ALIKE, "distance", method="average")
    groups = [[p for p, own in zip(pieces, group, strict=True) if own == n] for n in set(group)]
    found = [_as_legs(blocks, own) for own in groups if len(own) >= 3]
    return [legs for legs in found if legs.leg.max() >= 2]


def _airspeed(piece: Legs) -> float:
    """The mean indicated true airspeed [m/s]."""
    return float(piece.air.true_airspeed().mean())


def _stretches(blocks: Legs) -> Legs:
    """Return the blocks of straight and turning stretches in runs without labels, each a piece."""
    number, steady = np.zeros(len(blocks.time), dtype=np.intp), np.zeros(len(blocks.time), np.bool_)
    for run in np.unique(blocks.leg):
        own = np.flatnonzero(blocks.leg == run)
        if len(own) <= 2 * _WINDOW:
            continue
        turning = np.abs(_rate(blocks.at(own).track)) > _TURN_RATE
        steady[own] = turning | (np.abs(_rate(blocks.ground_speed[own])) < _ACCELERATION)
        changed = (np.diff(turning) != 0) | (np.diff(steady[own]) != 0)
        number[own] = number.max() + 1 + np.concatenate([[0], np.cumsum(changed)])
    return replace(blocks, leg=number).at(steady)


def _rate(values: Array) -> Array:
    """Rate of change per second, over a window around each block (narrower at the ends)."""
    last = len(values) - 1
    behind, ahead = (np.clip(np.arange(last + 1) + shift, 0, last) for shift in (-_WINDOW, _WINDOW))
    return np.asarray((values[ahead] - values[behind]) / ((ahead - behind) * SECOND))


def _holds(piece: Legs) -> bool:
    """Return whether airspeed and height are constant, by the means of the halves.

    Gusts average out in these, and drifts do not.
    """
    airspeed, pressure = _halves(piece.air.true_airspeed()), _halves(piece.air.static_pressure)
    return bool(np.ptp(airspeed) <= _DRIFT and np.ptp(pressure) <= _LEVEL * pressure[0])


def _halves(values: Array) -> Array:
    middle = len(values) // 2
    return np.array([values[:middle].mean(), values[middle:].mean()])


def _as_legs(blocks: Legs, pieces: list[Legs]) -> Legs:
    """Join pieces of the blocks, those on one track to one leg."""
    leg = by_track(unit(np.stack([p.ground_speed @ p.toward for p in pieces])))
    leg_of = np.full(int(blocks.leg.max()) + 1, -1)
    leg_of[[piece.leg[0] for piece in pieces]] = leg
    joined = replace(blocks, leg=leg_of[blocks.leg])
    return joined.at(joined.leg >= 0)


def _location(
    log: FlightLog, options: CalibrationOptions, found: Calibration | None
) -> tuple[float, float]:
    """Return the share of the static source in the answer, and what its doubt adds.

    The doubt is a deviation, as a share of the difference between the locations. Both are those of
    the curve's calibration, which is made here where it is not given and the height may tell.
    Without its evidence the static source is an assumption, and the difference is one standard
    deviation.
    """
    location, probability = options.error_location, None
    fit: Calibration | Reduction | None = found
    free = location == AUTO
    if free and fit is None and log.altitude is not None and options.use_altitude:
        with suppress(NoAnswerError, BadInputError):  # too few airspeeds for a curve
            fit = reduce_log(log, replace(options, method="covering", latency="given"))
    if fit is not None:
        location, probability = fit.error_location, fit.diagnostics.static_probability
    elif free:
        location = assumed_location(log.header)
    if probability is not None:
        return probability, float(np.sqrt(probability * (1.0 - probability)))
    static = location == STATIC
    return float(static), float(static and free and options.method == "covering")


# The bound of a fixed-speed answer, from the gusts and the sensor noise that the legs show. The
# residual of ground velocity and air data, without airspeed and wind, has the noise of a
# calibration: white noise plus the gust along the flight path. The noises that are likely come from
# all legs and turns of the log together, by its restricted likelihood. The methods are not least
# squares, so each likely noise is propagated with the weights of the method. The bound is that of
# the mixture over the noises. The likelihood treats the gusts of different groups as independent:
# each group has an airspeed and a wind of its own, and the cost is proportional to the length of
# the log. Compared with the likelihood of all legs at once, no 2σ of the five maneuvers and three
# data systems changes by more than 0.02 %.

_FLOOR = 1e-4  # m/s: keeps the covariance regular for legs without noise
# times the gusts: white noise so far above them that the covariance is linear in them
_FAR_ABOVE = 1e4


def two_sigma(groups: Sequence[SolvedGroup], priors: Priors = PRIORS) -> list[Array]:
    """Compute 2σ of the airspeed and the wind components [m/s], (3,), of each group."""
    noises, weights = plausible_noises(groups, priors)
    means = np.zeros((len(weights), 3))
    return [
        half_width(weights, means, np.sqrt(answer_variances(group, noises))) for group in groups
    ]


def plausible_noises(groups: Sequence[SolvedGroup], priors: Priors = PRIORS) -> tuple[Array, Array]:
    """Return the nodes of the noise's posterior, (m, 3), and their weights, (m,).

    A node is ln(gust deviation [m/s], gust length [m], white deviation [m/s]).
    """
    level = float(np.concatenate([group.residual for group in groups]).std())
    if level < _FLOOR:  # computed legs without noise
        return np.log([[_FLOOR, priors.gust_length_m, _FLOOR]]), np.ones(1)
    start = np.log([level, priors.gust_length_m, 0.3 * level])
    return weighted_noises(
        [(regression_of(group), noise_of(group)) for group in groups],
        wind_log_prior(priors, priors.gust_length_factor),
        start,
    )


def regression_of(group: SolvedGroup) -> Regression:
    """The equations of a group's seconds, with its airspeed and its wind as unknowns."""
    columns = np.column_stack([np.ones(len(group.along)), group.along])
    return Regression(group.residual, columns, columns, np.zeros(3))


def noise_of(group: SolvedGroup) -> WindNoise:
    """The noise of a group's seconds; that of the sensors is in the white part."""
    intervals = intervals_of(np.rint(group.group.time / SECOND).astype(np.intp), SECOND)
    airspeed = np.full(len(intervals.edges), float(group.answer[0]))
    return WindNoise(intervals, airspeed, group.along[None], np.zeros(len(group.along)), None)


def answer_variances(group: SolvedGroup, noises: Array) -> Array:
    """Variances of a group's airspeed and wind components [(m/s)²], (m, 3), under noises (m, 3).

    With the covariance S of the gusts and the gain g, gᵀSg = d (gᵀg − d gᵀ(S + d)⁻¹g) for white
    noise of a variance d far above S, to S/d.
    """
    deafened = noises.copy()
    deafened[:, 2] = noises[:, 0] + np.log(_FAR_ABOVE)
    far, squares = np.exp(2.0 * deafened[:, 2:]) + WHITE_FLOOR, np.sum(group.gain**2, axis=0)
    weighed = noise_of(group).stack(deafened).weigh(group.gain)
    gusts = far * (squares - far * np.einsum("nk,mnk->mk", group.gain, weighed))
    return np.asarray(gusts + np.exp(2.0 * noises[:, 2:]) * squares)


def fixed_speed_points(
    log: FlightLog,
    options: CalibrationOptions | None = None,
    found: Calibration | None = None,
) -> tuple[FixedSpeedPoint, ...]:
    """Return a point for each full turn and each group of legs on three or more tracks.

    The legs of a group are at one airspeed.

    The location of the error is that of the curve's calibration `found`; without one it is judged
    as a fit of the curve does. The used options are the row selection, the recovery factor, the
    error location, the priors of gusts and white noise, and the accuracies (stated, else the
    header's, else the usual ones). The 2σ covers gusts, sensor noise and GPS noise as found in the
    log, and the accuracies. Raises BadInputError for a log that cannot be used, NoAnswerError for
    one without such legs or turns.
    """
    with one_thread():
        return _points(log, options or CalibrationOptions(), found)


def _points(
    log: FlightLog, options: CalibrationOptions, found: Calibration | None
) -> tuple[FixedSpeedPoint, ...]:
    solved = [solve_group(group) for group in steady_groups(log, observe(log, options))]
    if not solved:
        raise NoAnswerError(
            "no fixed-speed point in this log: no full turn, and no three steady legs at one "
            "airspeed and height; "
            "fly four legs 90° apart, at least 5 s each, or a full turn at constant bank"
        )
    stated, place = accuracies_of(options.accuracies, log.header), _location(log, options, found)
    return tuple(
        _point(one, bound, stated, place)
        for one, bound in zip(solved, two_sigma(solved, priors_of(options.priors)), strict=True)
    )


def _point(
    one: SolvedGroup, bound: Array, stated: Accuracies, place: tuple[float, float]
) -> FixedSpeedPoint:
    """The point, with the doubt about the location of the error in its correction and its bound."""
    group, true, (share, doubt) = one.group, float(one.answer[0]), place
    (static, static_bound), (total, total_bound) = (
        replace(one.air, static_error=where).corrected(true, float(bound[0]), stated)
        for where in (True, False)
    )
    correction = total + share * (static - total)
    likely_bound = static_bound if share >= 0.5 else total_bound
    indicated = float(one.air.indicated_airspeed)
    return FixedSpeedPoint(
        method=one.method,
        legs=1 if group.turning else int(group.leg.max()) + 1,
        seconds=len(group.time) * SECOND,
        indicated_airspeed=indicated,
        calibrated_airspeed=indicated + correction,
        correction=correction,
        two_sigma=float(np.hypot(likely_bound, 2.0 * doubt * (static - total))),
        true_airspeed=true,
        true_airspeed_two_sigma=float(bound[0]),
        spread=one.spread,
        wind_north=float(one.answer[1]),
        wind_east=float(one.answer[2]),
        wind_two_sigma=float(np.hypot(bound[1:].max(), stated.velocity_mps)),
    )


def cross_check(
    log: FlightLog, options: CalibrationOptions | None = None, found: Calibration | None = None
) -> tuple[FixedSpeedPoint, ...]:
    """The fixed-speed points to compare a curve with; none where the log has no such legs or turns.

    `options` and `found` are as for `fixed_speed_points`.
    """
    try:
        return fixed_speed_points(log, options, found)
    except NoAnswerError:
        return ()
