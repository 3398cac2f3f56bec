"""Steady legs and turns in a log, grouped by airspeed, and the air that converts their airspeeds."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.calibration.observations import Observations
from pitotbench.calibration.options import AUTO, WITHOUT_TEMPERATURE, Accuracies, CalibrationOptions
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
_SAME_TRACK = 30.0 * DEGREE  # pieces whose tracks differ by less are one leg


@dataclass(frozen=True, slots=True)
class SteadyGroup:
    """Blocks at one airspeed and height, and the number of the leg of each, (n,). A turn is one
    leg.
    """

    blocks: SteadyBlocks
    leg: NDArray[np.intp]
    turning: bool

    @property
    def legs(self) -> int:
        """The number of legs."""
        return int(self.leg.max()) + 1

    def leg_means(self, data: Array) -> Array:
        """Means of (n,) or (n, k) data over each leg, (legs,) or (legs, k)."""
        return np.stack([data[self.leg == number].mean(axis=0) for number in range(self.legs)])


def steady_groups(log: FlightLog, obs: Observations) -> tuple[SteadyGroup, ...]:
    """Find full turns, and groups of straight legs on three tracks or more, sorted by airspeed."""
    blocks = block_means(log, obs)
    pieces = blocks.pieces() if labeled(log) else _found(blocks)
    long = [piece for piece in pieces if len(piece) * SECOND >= _SHORTEST and _holds(piece)]
    turns = [
        SteadyGroup(p, np.zeros(len(p), np.intp), True)
        for p in long
        if np.ptp(p.track) >= _FULL_TURN
    ]
    straight = [
        piece for piece in long if abs(float(np.diff(_halves(piece.track))[0])) <= _STRAIGHT
    ]
    groups = [_as_legs(pieces) for pieces in _by_airspeed(straight)]
    useful = [*turns, *(group for group in groups if group.legs >= 3)]
    return tuple(sorted(useful, key=lambda g: float(g.blocks.indicated_true_airspeed.mean())))


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


def _as_legs(pieces: list[SteadyBlocks]) -> SteadyGroup:
    """Join pieces on one track to one leg. The legs are numbered by track."""
    track = np.array([np.arctan2(piece.east.mean(), piece.north.mean()) for piece in pieces])
    order = np.argsort(track)
    gap = np.diff(track[order]) > _SAME_TRACK
    leg = np.empty(len(pieces), dtype=np.intp)
    leg[order] = np.concatenate([[0], np.cumsum(gap)])
    if (
        track[order[0]] + 2.0 * np.pi - track[order[-1]] <= _SAME_TRACK
    ):  # a leg on both sides of south
        leg[leg == leg.max()] = 0
    return SteadyGroup(
        _joined(pieces),
        np.concatenate([np.full(len(p), n) for p, n in zip(pieces, leg, strict=True)]),
        False,
    )


def _joined(pieces: list[SteadyBlocks]) -> SteadyBlocks:
    names = SteadyBlocks.__slots__
    return SteadyBlocks(
        *(np.concatenate([getattr(piece, name) for piece in pieces]) for name in names)
    )


_PART = 1e-3  # of a stated accuracy, the step of the difference: the whole zero offset may exceed the pressure


@dataclass(frozen=True, slots=True)
class LegAir:
    """Means over the legs of a group.

    `impact_pressure` and `static_pressure` [Pa] are indicated. `probe_heating` [-] is 0.2 r for a
    probe of total temperature [K] and 0 for air temperature. `static_error` states whether the
    pressure error is the static source's, and `standard_day` whether the temperature is that of a
    standard day.
    """

    impact_pressure: float
    static_pressure: float
    probe_temperature: float
    probe_heating: float
    static_error: bool
    standard_day: bool

    @property
    def indicated_airspeed(self) -> float:
        """Indicated airspeed [m/s]."""
        return float(air.calibrated_airspeed(self.impact_pressure))

    def calibrated_airspeed(self, true_airspeed: float) -> float:
        """Calibrated airspeed [m/s] for a true airspeed [m/s].

        Where the error is the static source's, the total pressure has none: p (1 + q/p) = p_i +
        q_i.
        """
        ratio = _ratio(true_airspeed, self.probe_temperature, self.probe_heating)
        pressure = self.static_pressure
        if self.static_error:
            pressure = (self.static_pressure + self.impact_pressure) / (1.0 + ratio)
        return float(air.calibrated_airspeed(pressure * ratio))

    def correction(self, true_airspeed: float) -> float:
        """Calibrated minus indicated airspeed [m/s] for a true airspeed [m/s]."""
        return self.calibrated_airspeed(true_airspeed) - self.indicated_airspeed

    def stated_two_sigma(self, true_airspeed: float, stated: Accuracies) -> float:
        """2σ of the correction [m/s] at a true airspeed [m/s] from the stated accuracies of the air
        data.

        The errors are independent. Those of GPS velocity change the wind alone, and a latency
        changes nothing at constant airspeed. A zero offset belongs to the correction, which is
        added to the raw reading: it only moves the total pressure, from which the true static
        pressure is found.
        """
        here = self.calibrated_airspeed(true_airspeed)
        parts = [
            (moved.calibrated_airspeed(true_airspeed) - here) / _PART
            for moved in self._each_moved(stated)
        ]
        return float(np.linalg.norm(parts))

    def _each_moved(self, stated: Accuracies) -> Iterator["LegAir"]:
        """Yield this air with one quantity at a time changed by a small part of its accuracy."""
        temperature = max(stated.temperature_k, WITHOUT_TEMPERATURE if self.standard_day else 0.0)
        recovery = 0.2 * stated.recovery_factor if self.probe_heating > 0.0 else 0.0
        yield replace(self, probe_temperature=self.probe_temperature + _PART * temperature)
        yield replace(self, probe_heating=self.probe_heating + _PART * recovery)
        yield replace(
            self, static_pressure=self.static_pressure + _PART * stated.static_pressure_pa
        )
        yield replace(
            self, impact_pressure=self.impact_pressure + _PART * stated.impact_pressure_zero_pa
        )


def leg_air(group: SteadyGroup, obs: Observations, static_error: bool) -> LegAir:
    """Average the air of a group. Every leg has the same weight, as in the methods' airspeed."""
    blocks = group.blocks
    indicated_true, pressure, probe = (
        float(group.leg_means(channel).mean())
        for channel in (
            blocks.indicated_true_airspeed,
            blocks.static_pressure,
            blocks.probe_temperature,
        )
    )
    impact = pressure * _ratio(indicated_true, probe, obs.probe_heating)
    return LegAir(impact, pressure, probe, obs.probe_heating, static_error, obs.standard_day)


def _ratio(true_airspeed: float, probe_temperature: float, probe_heating: float) -> float:
    """q_c/p for a true airspeed [m/s] and a probe temperature [K], with T = T_t − 0.2 r V²/(γR)."""
    heating = probe_heating * true_airspeed**2 / (air.HEAT_RATIO * air.GAS_CONSTANT)
    return float(
        air.impact_pressure_from_true_airspeed(true_airspeed, 1.0, probe_temperature - heating)
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
