"""Steady legs and turns in a log, grouped by airspeed, for the fixed-speed methods.

Where the log marks what was on condition, the marks are used. Else straight legs and turns are found from the
ground velocity, which gusts change less than the air data. In both cases a piece must be long enough, straight or a
full turn, level, and of constant airspeed.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibrate.rows.observations import Observations
from pitotbench.calibrate.rows.steady_blocks import SECOND, SteadyBlocks, block_means, labeled
from pitotbench.records.log import FlightLog
from pitotbench.units import DEGREE, KNOT, Array

_SHORTEST = 5.0  # s, the least on condition that Martos, Kiszely and Foster (2011), III.A, allow a leg
_STRAIGHT = 5.0 * DEGREE  # largest change of mean track between the halves of a straight leg
_FULL_TURN = (
    300.0 * DEGREE
)  # least change of track of a turn: the ground velocities of a smaller one are only an arc
_TURN_RATE = 1.0 * DEGREE  # rad/s: straight flight below, a third of a standard-rate turn above (no labels)
_ACCELERATION = 0.5 * KNOT  # m/s² of ground speed: above it the airspeed is being changed (no labels)
_WINDOW = 2  # blocks to either side, for rates of change (no labels)
_DRIFT = 3.0 * KNOT  # m/s of airspeed: limit between the halves of a piece and between neighbors of one group
_LEVEL = 0.01  # of static pressure, about 300 ft: limit between the halves of a piece and between neighbors
_SAME_TRACK = 30.0 * DEGREE  # pieces whose tracks differ by less are one leg


@dataclass(frozen=True, slots=True)
class SteadyGroup:
    """Blocks at one airspeed and height, and the number of the leg of each, (n,). A turn is one leg."""

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
    turns = [SteadyGroup(p, np.zeros(len(p), np.intp), True) for p in long if np.ptp(p.track) >= _FULL_TURN]
    straight = [piece for piece in long if abs(float(np.diff(_halves(piece.track))[0])) <= _STRAIGHT]
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
    """Whether airspeed and height are constant: in the means of the halves gusts average out, and drifts do not."""
    airspeed, pressure = _halves(piece.indicated_true_airspeed), _halves(piece.static_pressure)
    return bool(np.ptp(airspeed) <= _DRIFT and np.ptp(pressure) <= _LEVEL * pressure[0])


def _halves(values: Array) -> Array:
    middle = len(values) // 2
    return np.array([values[:middle].mean(), values[middle:].mean()])


def _by_airspeed(pieces: list[SteadyBlocks]) -> list[list[SteadyBlocks]]:
    """Group pieces by height, then by airspeed. No chain of neighbors spans more than twice the limit."""
    levels = _chains(pieces, [float(np.log(piece.static_pressure.mean())) for piece in pieces], _LEVEL)
    return [
        chain
        for level in levels
        for chain in _chains(level, [float(piece.indicated_true_airspeed.mean()) for piece in level], _DRIFT)
    ]


def _chains(pieces: list[SteadyBlocks], values: list[float], step: float) -> list[list[SteadyBlocks]]:
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
    if track[order[0]] + 2.0 * np.pi - track[order[-1]] <= _SAME_TRACK:  # a leg on both sides of south
        leg[leg == leg.max()] = 0
    return SteadyGroup(
        _joined(pieces), np.concatenate([np.full(len(p), n) for p, n in zip(pieces, leg, strict=True)]), False
    )


def _joined(pieces: list[SteadyBlocks]) -> SteadyBlocks:
    names = SteadyBlocks.__slots__
    return SteadyBlocks(*(np.concatenate([getattr(piece, name) for piece in pieces]) for name in names))
