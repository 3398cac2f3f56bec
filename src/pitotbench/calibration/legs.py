"""Steady legs and turns in a log, grouped by airspeed, and the likely location of the error."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibration.leg_air import LegAir
from pitotbench.calibration.leg_methods import Legs, by_track, unit
from pitotbench.calibration.observations import Observations
from pitotbench.calibration.options import AUTO, CalibrationOptions
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.log import FlightLog
from pitotbench.units import DEGREE, KNOT, Array, Seconds

# A log as one-second means over uninterrupted runs, for the search for steady legs and turns.

SECOND = 1.0  # s, length of a block: short against a gust, long against the sampling
_WHOLE = 0.8  # share of a block's rows that must be present


def labeled(log: FlightLog) -> bool:
    """Whether the log marks any row as on condition."""
    return log.on_condition is not None and bool(log.on_condition.any())


def block_means(log: FlightLog, obs: Observations) -> Legs:
    """Average the log's rows in blocks; where the log marks rows as on condition, those alone. A
    run is a piece; `time` [s] is the middle of the block.
    """
    run = _runs(log, obs)
    north, east = obs.velocity_north, obs.velocity_east
    channels = np.stack(
        [
            obs.impact_pressure,
            obs.static_pressure,
            obs.probe_temperature,
            np.hypot(north, east),  # the mean of a turning vector is too short
            north,
            east,
        ]
    )
    rows_a_block = SECOND / float(np.median(np.diff(obs.time)))
    rows = np.flatnonzero(run >= 0)
    table = _means(obs.time[rows], channels[:, rows], rows_a_block, run[rows])
    time, impact, pressure, temperature, speed, north, east, number = table
    return Legs(
        LegAir(impact, pressure, temperature, obs.probe_heating, standard_day=obs.standard_day),
        time,
        speed,
        unit(np.stack([north, east], axis=1)),
        np.zeros(len(time), dtype=np.bool_),
        number.astype(np.intp),
    )


def _runs(log: FlightLog, obs: Observations) -> NDArray[np.intp]:
    """The number of each row's run; −1 where the row is not on condition.

    A run is a segment without its rows off condition. In a log without segments it is an
    uninterrupted stretch on condition.
    """
    changed = np.diff(obs.stretch) != 0
    on = np.ones(len(obs), dtype=np.bool_)
    if log.on_condition is not None and labeled(log):
        on = log.on_condition[obs.used]
    if log.segment is not None:
        segment = log.segment[obs.used]
        changed |= segment[1:] != segment[:-1]
    else:
        changed |= on[1:] != on[:-1]
    return np.where(on, np.concatenate([[0], np.cumsum(changed)]), -1)


def _means(time: Seconds, channels: Array, rows_a_block: float, run: NDArray[np.intp]) -> Array:
    """Time, means and number of the run, (c + 2, blocks), for rows (n,) in runs. Incomplete blocks
    are left out.
    """
    if not len(run):
        return np.zeros((len(channels) + 2, 0))
    begun = np.diff(run, prepend=-1) != 0
    start = time[begun][np.cumsum(begun) - 1]  # of the row's run
    # Only blocks that have rows are formed: with one wrong time stamp, all up to the last would
    # fill the memory.
    block = np.floor((time - start) / SECOND + 1e-6)
    first = np.flatnonzero(begun | (np.diff(block, prepend=-1.0) != 0.0))
    count = np.diff(first, append=len(run))
    index = np.repeat(np.arange(len(first)), count)
    whole = count >= _WHOLE * rows_a_block
    means = np.stack([np.bincount(index, channel) for channel in channels])[:, whole] / count[whole]
    middle = start[first] + (block[first] + 0.5) * SECOND
    return np.vstack([middle[whole], means, run[first][whole]])


# Where the log marks what was on condition, the marks are used. Else straight legs and turns are
# found from the ground velocity, which gusts change less than the air data. In both cases a piece
# must be long enough, straight or a full turn, level, and of constant airspeed.

_SHORTEST = (
    5.0  # s, the least on condition that Martos, Kiszely and Foster (2011), III.A, allow a leg
)
_STRAIGHT = 5.0 * DEGREE  # largest change of mean track between the halves of a straight leg
_FULL_TURN = (
    300.0 * DEGREE
)  # least change of track of a turn: the ground velocities of a smaller one are only an arc
_TURN_RATE = (
    1.0 * DEGREE
)  # rad/s: straight flight below, a third of a standard-rate turn above (no labels)
_ACCELERATION = (
    0.5 * KNOT
)  # m/s² of ground speed: above it the airspeed is being changed (no labels)
_WINDOW = 2  # blocks to either side, for rates of change (no labels)
_DRIFT = (
    3.0 * KNOT
)  # m/s of airspeed: limit between the halves of a piece and between neighbors of one group
_LEVEL = 0.01  # of static pressure, about 300 ft: limit between the halves of a piece and between neighbors


def steady_groups(log: FlightLog, obs: Observations) -> tuple[Legs, ...]:
    """Find full turns, and groups of straight legs on three tracks or more, sorted by airspeed."""
    blocks = block_means(log, obs)
    if not labeled(log):
        blocks = _stretches(blocks)
    long = [p for p in blocks.pieces() if len(p.time) * SECOND >= _SHORTEST and _holds(p)]
    turns = [
        replace(piece, leg=0 * piece.leg, turning=True)
        for piece in long
        if np.ptp(piece.track) >= _FULL_TURN
    ]
    straight = [
        piece for piece in long if abs(float(np.diff(_halves(piece.track))[0])) <= _STRAIGHT
    ]
    groups = [_as_legs(blocks, pieces) for pieces in _by_airspeed(straight)]
    useful = [*turns, *(group for group in groups if group.legs >= 3)]
    return tuple(sorted(useful, key=_airspeed))


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
    """Whether airspeed and height are constant: in the means of the halves gusts average out, and
    drifts do not.
    """
    airspeed, pressure = _halves(piece.air.true_airspeed()), _halves(piece.air.static_pressure)
    return bool(np.ptp(airspeed) <= _DRIFT and np.ptp(pressure) <= _LEVEL * pressure[0])


def _halves(values: Array) -> Array:
    middle = len(values) // 2
    return np.array([values[:middle].mean(), values[middle:].mean()])


def _by_airspeed(pieces: list[Legs]) -> list[list[Legs]]:
    """Group pieces by height, then by airspeed. No chain of neighbors spans more than twice the
    limit.
    """
    heights = [float(np.log(piece.air.static_pressure.mean())) for piece in pieces]
    return [
        chain
        for level in _chains(pieces, heights, _LEVEL)
        for chain in _chains(level, [_airspeed(piece) for piece in level], _DRIFT)
    ]


def _chains(pieces: list[Legs], values: list[float], step: float) -> list[list[Legs]]:
    chains: list[list[Legs]] = []
    first = last = -np.inf
    for place in np.argsort(values):
        value = values[place]
        if value - last > step or value - first > 2.0 * step:
            chains.append([])
            first = value
        chains[-1].append(pieces[place])
        last = value
    return chains


def _as_legs(blocks: Legs, pieces: list[Legs]) -> Legs:
    """Join pieces of the blocks, those on one track to one leg. The legs are numbered by track."""
    leg = by_track(np.array([np.arctan2(*(p.ground_speed @ p.toward)[::-1]) for p in pieces]))
    leg_of = np.full(int(blocks.leg.max()) + 1, -1)
    leg_of[[piece.leg[0] for piece in pieces]] = leg
    joined = replace(blocks, leg=leg_of[blocks.leg])
    return joined.at(joined.leg >= 0)


# The location of the pressure error for the fixed-speed methods, as a fit of the curve judges it.

_STATIC = "static"


@dataclass(frozen=True, slots=True)
class LikelyLocation:
    """`static` is the share of the static source in the answer.

    `doubt` is the standard deviation that the location adds, as a share of the difference between
    the locations.
    """

    static: float
    doubt: float


def location_of(
    options: CalibrationOptions, location: str, probability: float | None = None
) -> LikelyLocation:
    """The location that a calibration found: its options, its place of the error and the
    probability of a static source, None without evidence."""
    if probability is not None:
        return LikelyLocation(probability, float((probability * (1.0 - probability)) ** 0.5))
    # Without evidence the static source is an assumption, and the difference is one standard
    # deviation.
    assumed = (
        options.error_location == AUTO and options.method == "covering" and location == _STATIC
    )
    return LikelyLocation(float(location == _STATIC), float(assumed))


def likely_location(log: FlightLog, options: CalibrationOptions) -> LikelyLocation:
    """Judge the location by the height where the log has it; else take the usual one, with doubt."""
    if options.error_location != AUTO:
        return location_of(options, options.error_location)
    from pitotbench.calibration.location import (
        assumed_location,
    )  # slow to load; a stated location needs no fit
    from pitotbench.calibration.reduction import reduce_log

    if log.altitude is not None and options.use_altitude:
        try:
            fit = reduce_log(log, replace(options, method="covering", latency="given"))
        except (NoAnswerError, BadInputError):  # too few airspeeds for a curve
            pass
        else:
            return location_of(options, fit.error_location, fit.diagnostics.static_probability)
    return location_of(options, assumed_location(log.header))
