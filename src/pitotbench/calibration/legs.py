"""Steady legs and turns in a log, grouped by airspeed, and the likely location of the error."""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.calibration.leg_air import LegAir, impact_ratio
from pitotbench.calibration.leg_methods import LegGroup, by_track, means_by_leg
from pitotbench.calibration.observations import Observations
from pitotbench.calibration.options import AUTO, CalibrationOptions
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.log import FlightLog
from pitotbench.units import DEGREE, KNOT, Array, Booleans, Kelvin, MetersPerSecond, Pascal, Seconds

# A log as one-second means over uninterrupted runs, for the search for steady legs and turns.

SECOND = 1.0  # s, length of a block: short against a gust, long against the sampling
_WHOLE = 0.8  # share of a block's rows that must be present


@dataclass(frozen=True, slots=True)
class SteadyBlocks:
    """Block means, (n,), in SI units. `time` [s] is the middle of the block.

    `indicated_true_airspeed` [m/s] is the true airspeed without a correction of the pressure error.
    `piece` is the number of the piece of flight to which the block belongs.
    """

    time: Seconds
    north: MetersPerSecond
    east: MetersPerSecond
    indicated_true_airspeed: MetersPerSecond
    static_pressure: Pascal
    probe_temperature: Kelvin
    piece: NDArray[np.intp]

    def __len__(self) -> int:
        return len(self.time)

    @property
    def velocity(self) -> Array:
        """Ground velocity toward north and east [m/s], (n, 2)."""
        return np.stack([self.north, self.east], axis=1)

    @property
    def track(self) -> Array:
        """Ground track without jumps [rad]."""
        return np.unwrap(np.arctan2(self.east, self.north))

    def at(self, rows: Booleans | NDArray[np.intp]) -> "SteadyBlocks":
        """The chosen blocks."""
        return SteadyBlocks(*(getattr(self, field.name)[rows] for field in fields(self)))

    def pieces(self) -> list["SteadyBlocks"]:
        """Split the blocks into pieces, in the order of their numbers."""
        order = np.argsort(self.piece, kind="stable")
        first = np.flatnonzero(np.diff(self.piece[order], prepend=-1))
        return [self.at(rows) for rows in np.split(order, first[1:])] if len(order) else []


def labeled(log: FlightLog) -> bool:
    """Whether the log marks any row as on condition."""
    return log.on_condition is not None and bool(log.on_condition.any())


def block_means(log: FlightLog, obs: Observations) -> SteadyBlocks:
    """Average the log's rows in blocks; where the log marks rows as on condition, those alone. A
    run is a piece.
    """
    run = _runs(log, obs)
    mach = air.mach_from_impact_pressure(obs.impact_pressure, obs.static_pressure)
    airspeed = mach * air.sound_speed(obs.probe_temperature / (1.0 + obs.probe_heating * mach**2))
    north, east = obs.velocity_north, obs.velocity_east
    channels = np.stack(
        [north, east, airspeed, obs.static_pressure, obs.probe_temperature, np.hypot(north, east)]
    )
    rows_a_block = SECOND / float(np.median(np.diff(obs.time)))
    rows = np.flatnonzero(run >= 0)
    table = _means(obs.time[rows], channels[:, rows], rows_a_block, run[rows])
    table[1:3] *= table[6] / np.hypot(*table[1:3])  # the mean of a turning vector is too short
    time, north, east, airspeed, pressure, temperature, _, number = table
    return SteadyBlocks(time, north, east, airspeed, pressure, temperature, number.astype(np.intp))


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


def steady_groups(log: FlightLog, obs: Observations) -> tuple[LegGroup, ...]:
    """Find full turns, and groups of straight legs on three tracks or more, sorted by airspeed."""
    blocks = block_means(log, obs)
    pieces = blocks.pieces() if labeled(log) else _found(blocks)
    long = [piece for piece in pieces if len(piece) * SECOND >= _SHORTEST and _holds(piece)]
    turns = [
        _group(p, np.zeros(len(p), np.intp), obs, turning=True)
        for p in long
        if np.ptp(p.track) >= _FULL_TURN
    ]
    straight = [
        piece for piece in long if abs(float(np.diff(_halves(piece.track))[0])) <= _STRAIGHT
    ]
    groups = [_group(*_as_legs(pieces), obs) for pieces in _by_airspeed(straight)]
    useful = [*turns, *(group for group in groups if group.legs >= 3)]
    return tuple(sorted(useful, key=lambda group: float(group.airspeed.mean())))


def _group(
    blocks: SteadyBlocks, leg: NDArray[np.intp], obs: Observations, turning: bool = False
) -> LegGroup:
    """Make a group of blocks with the numbers of their legs. Every leg has the same weight in the
    mean air, as in the methods' airspeed.
    """
    order = np.argsort(blocks.time)
    blocks, leg = blocks.at(order), leg[order]
    channels = (blocks.indicated_true_airspeed, blocks.static_pressure, blocks.probe_temperature)
    airspeed, pressure, probe = (means_by_leg(channel, leg).mean() for channel in channels)
    impact = pressure * impact_ratio(airspeed, probe, obs.probe_heating)
    indicated = LegAir(impact, pressure, probe, obs.probe_heating, standard_day=obs.standard_day)
    speed = np.hypot(blocks.north, blocks.east)
    return LegGroup(
        indicated,
        blocks.time,
        blocks.indicated_true_airspeed,
        speed,
        blocks.velocity / speed[:, None],
        np.zeros(len(leg), dtype=np.bool_),
        leg,
        turning,
    )


def _found(blocks: SteadyBlocks) -> list[SteadyBlocks]:
    """Find straight and turning stretches in runs without labels."""
    stretches = []
    for run in blocks.pieces():
        if len(run) <= 2 * _WINDOW:
            continue
        turning = np.abs(_rate(run.track)) > _TURN_RATE
        steady = turning | (np.abs(_rate(np.hypot(run.north, run.east))) < _ACCELERATION)
        changed = (np.diff(turning) != 0) | (np.diff(steady) != 0)
        stretch = np.concatenate([[0], np.cumsum(changed)])
        stretches += replace(run, piece=stretch).at(steady).pieces()
    return stretches


def _rate(values: Array) -> Array:
    """Rate of change per second, over a window around each block (narrower at the ends)."""
    last = len(values) - 1
    behind, ahead = (np.clip(np.arange(last + 1) + shift, 0, last) for shift in (-_WINDOW, _WINDOW))
    return np.asarray((values[ahead] - values[behind]) / ((ahead - behind) * SECOND))


def _holds(piece: SteadyBlocks) -> bool:
    """Whether airspeed and height are constant: in the means of the halves gusts average out, and
    drifts do not.
    """
    airspeed, pressure = _halves(piece.indicated_true_airspeed), _halves(piece.static_pressure)
    return bool(np.ptp(airspeed) <= _DRIFT and np.ptp(pressure) <= _LEVEL * pressure[0])


def _halves(values: Array) -> Array:
    middle = len(values) // 2
    return np.array([values[:middle].mean(), values[middle:].mean()])


def _by_airspeed(pieces: list[SteadyBlocks]) -> list[list[SteadyBlocks]]:
    """Group pieces by height, then by airspeed. No chain of neighbors spans more than twice the
    limit.
    """
    levels = _chains(
        pieces, [float(np.log(piece.static_pressure.mean())) for piece in pieces], _LEVEL
    )
    return [
        chain
        for level in levels
        for chain in _chains(
            level, [float(piece.indicated_true_airspeed.mean()) for piece in level], _DRIFT
        )
    ]


def _chains(
    pieces: list[SteadyBlocks], values: list[float], step: float
) -> list[list[SteadyBlocks]]:
    chains: list[list[SteadyBlocks]] = []
    first = last = -np.inf
    for place in np.argsort(values):
        value = values[place]
        if value - last > step or value - first > 2.0 * step:
            chains.append([])
            first = value
        chains[-1].append(pieces[place])
        last = value
    return chains


def _as_legs(pieces: list[SteadyBlocks]) -> tuple[SteadyBlocks, NDArray[np.intp]]:
    """Join pieces on one track to one leg. Return the blocks and the number of the leg of each, by
    track.
    """
    leg = by_track(np.array([np.arctan2(p.east.mean(), p.north.mean()) for p in pieces]))
    return _joined(pieces), np.repeat(leg, [len(piece) for piece in pieces])


def _joined(pieces: list[SteadyBlocks]) -> SteadyBlocks:
    names = SteadyBlocks.__slots__
    return SteadyBlocks(
        *(np.concatenate([getattr(piece, name) for piece in pieces]) for name in names)
    )


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
