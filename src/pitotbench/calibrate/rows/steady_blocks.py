"""A log as one-second means over uninterrupted runs, for the search for steady legs and turns."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.records.log import FlightLog
from pitotbench.units import Array, Booleans, Kelvin, MetersPerSecond, Pascal, Seconds

SECOND = 1.0  # s, length of a block: short against a gust, long against the sampling
_WHOLE = 0.8  # share of a block's rows that must be present


@dataclass(frozen=True, slots=True)
class SteadyBlocks:
    """Block means, (n,), in SI units. `time` [s] is the middle of the block.

    `indicated_true_airspeed` [m/s] is the true airspeed without a correction of the pressure error. `piece` is the
    number of the piece of flight to which the block belongs.
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
    """Average the log's rows in blocks; where the log marks rows as on condition, those alone. A run is a piece."""
    run = _runs(log, obs)
    mach = air.mach_from_impact_pressure(obs.impact_pressure, obs.static_pressure)
    airspeed = mach * air.sound_speed(obs.probe_temperature / (1.0 + obs.probe_heating * mach**2))
    north, east = obs.velocity_north, obs.velocity_east
    channels = np.stack([north, east, airspeed, obs.static_pressure, obs.probe_temperature, np.hypot(north, east)])
    rows_a_block = SECOND / float(np.median(np.diff(obs.time)))
    rows = np.flatnonzero(run >= 0)
    table = _means(obs.time[rows], channels[:, rows], rows_a_block, run[rows])
    table[1:3] *= table[6] / np.hypot(*table[1:3])  # the mean of a turning vector is too short
    time, north, east, airspeed, pressure, temperature, _, number = table
    return SteadyBlocks(time, north, east, airspeed, pressure, temperature, number.astype(np.intp))


def _runs(log: FlightLog, obs: Observations) -> NDArray[np.intp]:
    """The number of each row's run; −1 where the row is not on condition.

    A run is a segment without its rows off condition. In a log without segments it is an uninterrupted stretch on
    condition.
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
    """Time, means and number of the run, (c + 2, blocks), for rows (n,) in runs. Incomplete blocks are left out."""
    if not len(run):
        return np.zeros((len(channels) + 2, 0))
    begun = np.diff(run, prepend=-1) != 0
    start = time[begun][np.cumsum(begun) - 1]  # of the row's run
    # Only blocks that have rows are formed: with one wrong time stamp, all up to the last would fill the memory.
    block = np.floor((time - start) / SECOND + 1e-6)
    first = np.flatnonzero(begun | (np.diff(block, prepend=-1.0) != 0.0))
    count = np.diff(first, append=len(run))
    index = np.repeat(np.arange(len(first)), count)
    whole = count >= _WHOLE * rows_a_block
    means = np.stack([np.bincount(index, channel) for channel in channels])[:, whole] / count[whole]
    middle = start[first] + (block[first] + 0.5) * SECOND
    return np.vstack([middle[whole], means, run[first][whole]])
