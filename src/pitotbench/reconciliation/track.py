"""The track: a measured log on uniform rows, and the filter of all channels at its instants.

A track has stretches between pauses and outages, in which the GPS is interpolated. Both sides of
every comparison pass the same symmetric filter at the same instants. A comparison must not contain
a hold of the last fix, a window that is not symmetric, or a rectangle rule: each looks like a delay
of half a sample interval.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.sparse import coo_array, csr_array

from pitotbench import air
from pitotbench.channels import CHANNELS, numbers_from
from pitotbench.records import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.timeline import Indices, in_outage, interval, pauses, stretches
from pitotbench.units import Array, Booleans, Kelvin, Seconds

FORCES = ("specific_force_x", "specific_force_y", "specific_force_z")
GPS_CHANNELS, AIR_CHANNELS = numbers_from("gps"), numbers_from("air")
HALF_WINDOW = 0.2  # s, of the filter
SLOW_GPS = 0.3  # s between fixes from which they are not filtered: the filter would hold one or two of them
SHORTEST = 10.0  # s, of a stretch that is used
FEWEST_FIXES = 4  # of a stretch, for a cubic spline


@dataclass(frozen=True, slots=True)
class Track:
    """Channels by the field names of a FlightLog, each (n,), on uniform rows.

    `start` holds the first row of every stretch and, last, the number of rows. `fix` holds the rows
    of the GPS fixes, `fix_period` and `row_period` are in seconds. `coarse` [s] is the time between
    the states in which the changes of the model's answer are measured.
    """

    time: Seconds
    channels: Mapping[str, Array]
    start: tuple[int, ...]
    fix: Indices
    fix_period: float
    row_period: float
    coarse: float = 1.0

    def __getitem__(self, name: str) -> Array:
        return self.channels[name]

    def __contains__(self, name: str) -> bool:
        return name in self.channels

    def replaced(self, changed: Mapping[str, Array]) -> "Track":
        """Return the same rows with some channels replaced."""
        return replace(self, channels={**self.channels, **changed})


def track_of(log: FlightLog, fresh_air: Booleans | None = None) -> Track:
    """Return the track of a log.

    `fresh_air` is false on rows whose air data only repeat the previous row.

    Lost rows are filled by interpolation. A pause in the recording ends a stretch, and so does an
    outage of the GPS or of the air data, of which no row is used. Raises BadInputError where no
    stretch is long enough to be used, or where the GPS velocity never changes.
    """
    period = interval(log.time)
    fresh = log.fresh_fixes()
    fix_time = log.time[fresh]
    if len(fix_time) < 2:
        raise BadInputError(
            "the log holds fewer than two GPS fixes: nothing can be compared; use another log"
        )
    used = [rows for rows in _observed(log, fresh_air) if _long_enough(log.time[rows])]
    if not used:
        raise BadInputError(
            f"the log holds no stretch of {SHORTEST:.0f} s without a pause or an outage of the GPS "
            "or air data: "
            "nothing can be compared"
        )
    fix_period = interval(fix_time)
    times = [_uniform(log.time[rows], period) for rows in used]
    names = [n for n, a in log.channels().items() if a.dtype == np.float64 and n != "time"]
    channels = {
        name: np.concatenate(
            [
                _regular(log, name, p, t, _new(name, fresh, fresh_air))
                for p, t in zip(used, times, strict=True)
            ]
        )
        for name in names
    }
    time = np.concatenate(times)
    start = (0, *np.cumsum([len(t) for t in times]).tolist())
    return Track(time, channels, start, _rows_of(time, fix_time, period), fix_period, period)


def mach_number(track: Track) -> Array:
    """Return the Mach number of the pressures, (n,); impact pressures below 1 Pa count as 1 Pa."""
    return air.mach_from_impact_pressure(
        np.maximum(track["impact_pressure"], 1.0), track["static_pressure"]
    )


def outside_temperature(track: Track, mach: Array) -> Kelvin:
    """Return the air temperature [K] of a track: measured, or that of a standard day."""
    if "air_temperature" in track:
        return track["air_temperature"]
    if "total_temperature" in track:
        return air.air_temperature(track["total_temperature"], mach)
    return air.standard_temperature(air.pressure_altitude(track["static_pressure"]))


def _observed(log: FlightLog, fresh_air: Booleans | None) -> list[slice]:
    """The rows of each stretch in which GPS and air data are new often enough."""
    in_outages = in_outage(log.time, log.renewed_fixes())
    if fresh_air is not None:
        in_outages = in_outages | in_outage(log.time, fresh_air)
    changes = np.flatnonzero(np.diff(in_outages.astype(np.int8))) + 1
    parts = stretches(log.time, np.union1d(pauses(log.time), changes))
    return [rows for rows in parts if not in_outages[rows.start]]


def _long_enough(time: Seconds) -> bool:
    return len(time) > 1 and bool(time[-1] - time[0] >= SHORTEST)


def _uniform(time: Seconds, period: float) -> Seconds:
    """Uniform times that cover a stretch."""
    count = round(float(time[-1] - time[0]) / period) + 1
    return np.asarray(time[0] + period * np.arange(count))


def _new(name: str, gps: Booleans, air_data: Booleans | None) -> Booleans | None:
    """The rows with a new sample of a channel; None where all rows are new."""
    return gps if name in GPS_CHANNELS else air_data if name in AIR_CHANNELS else None


def _regular(
    log: FlightLog, name: str, rows: slice, time: Seconds, fresh: Booleans | None
) -> Array:
    """One channel of one stretch on uniform rows."""
    values = np.asarray(getattr(log, name), dtype=np.float64)[rows]
    values = np.unwrap(values) if CHANNELS[name].wraps else values
    recorded = log.time[rows]
    if fresh is not None and not fresh[rows].all():
        new = fresh[rows].copy()
        new[0] = False  # a fix that may be held from before the stretch has no known time
        if new.sum() < FEWEST_FIXES:
            return np.interp(time, recorded, values)
        inside = np.clip(time, recorded[new][0], recorded[new][-1])
        return np.asarray(CubicSpline(recorded[new], values[new])(inside))
    return np.interp(time, recorded, values)


def _rows_of(time: Seconds, wanted: Seconds, period: float) -> Indices:
    """Rows whose time is the time of a fix."""
    row = np.clip(np.searchsorted(time, wanted - 0.5 * period), 0, len(time) - 1)
    at_fix: Indices = row[np.abs(time[row] - wanted) < 0.51 * period]  # half a row, and rounding
    return at_fix


STEP = 0.5  # s between instants; the period of the GPS fixes where it is longer
# s at both ends of a stretch that are not used: the filter and the smoothing end there
MARGIN = 1.0


@dataclass(frozen=True, slots=True)
class Grid:
    """The instants of a track.

    `rows` are the rows at the centers, (n,); `first` is true at the first instant of every stretch;
    `step` [s] is the time between instants. `taps` are the weights of the filter over the rows
    around a center: symmetric, with the sum 1. A slow GPS is not filtered (`filters_gps` is False).
    """

    rows: Indices
    first: NDArray[np.bool_]
    step: float
    taps: Array
    filters_gps: bool
    _kept: list[tuple[Indices, csr_array]] = field(default_factory=list, compare=False, repr=False)

    def __len__(self) -> int:
        return len(self.rows)

    def smooth(self, values: Array, gps: bool = False) -> Array:
        """Return a channel at the instants, filtered.

        The fixes of a slow GPS are taken as they are.
        """
        return self._at(self.rows, values, gps)

    def smooth_answer(self, values: Array, rows: Indices) -> Array:
        """Return columns of some rows, (m, k), through the same filter at the instants, (n, k)."""
        return np.asarray(self._answer_weights(rows) @ values)

    def _answer_weights(self, rows: Indices) -> csr_array:
        """Return the filter from values at some rows to the instants, (n, m), the last one kept."""
        if not self._kept or self._kept[0][0] is not rows:
            self._kept[:] = [(rows, self._new_weights(rows))]
        return self._kept[0][1]

    def _new_weights(self, rows: Indices) -> csr_array:
        half = len(self.taps) // 2
        wanted = np.clip(self.rows[:, None] + np.arange(-half, half + 1), rows[0], rows[-1])
        before = np.clip(np.searchsorted(rows, wanted, side="right") - 1, 0, len(rows) - 2)
        share = (wanted - rows[before]) / (rows[before + 1] - rows[before])
        instant = np.arange(len(wanted))[:, None] * np.ones_like(before)
        weights = coo_array(
            (
                np.concatenate([(self.taps * (1.0 - share)).ravel(), (self.taps * share).ravel()]),
                (np.tile(instant.ravel(), 2), np.concatenate([before.ravel(), before.ravel() + 1])),
            ),
            shape=(len(wanted), len(rows)),
        )
        return weights.tocsr()

    def _at(self, rows: Indices, values: Array, gps: bool) -> Array:
        if gps and not self.filters_gps:
            return values[rows]
        half = len(self.taps) // 2
        around = np.clip(rows[:, None] + np.arange(-half, half + 1), 0, len(values) - 1)
        return np.asarray(values[around] @ self.taps)

    def mean_between(self, values: Array, gps: bool = False) -> Array:
        """Return a channel's mean from the previous instant to each, 0 where a stretch begins.

        The integral by the trapezoidal rule passes the same filter as velocities do.
        """
        total = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]))])
        integral = self.smooth(total, gps)
        rows = np.diff(self.rows, prepend=self.rows[0])
        mean = np.diff(integral, prepend=integral[0]) / np.maximum(rows, 1)
        return np.where(self.first, 0.0, mean)

    def rate(self, values: Array, track: Track) -> Array:
        """Return the change a second since the previous instant, (n,), 0 where a stretch begins."""
        seconds = np.maximum(np.diff(self.rows, prepend=self.rows[0]), 1) * track.row_period
        return np.where(self.first, 0.0, np.diff(values, prepend=values[0]) / seconds)


def grid_of(track: Track) -> Grid:
    """Return the instants of a track."""
    slow = track.fix_period >= SLOW_GPS
    margin = int(np.ceil(MARGIN / track.row_period))
    half = max(1, round(HALF_WINDOW / track.row_period))
    every = (
        max(1, int(np.ceil(STEP / track.fix_period - 0.01)))
        if slow
        else max(1, round(STEP / track.row_period))
    )
    rows, first = [], []
    for begin, end in zip(track.start[:-1], track.start[1:], strict=True):
        if slow:
            fixes = track.fix[(track.fix >= begin + margin) & (track.fix < end - margin)]
            chosen = fixes[::every]
        else:
            chosen = np.arange(begin + margin, end - margin, every)
        rows.append(chosen)
        first.append(np.arange(len(chosen)) == 0)
    step = every * (track.fix_period if slow else track.row_period)
    taps = np.ones(2 * half + 1)
    taps[[0, -1]] = 0.5
    return Grid(np.concatenate(rows), np.concatenate(first), step, taps / taps.sum(), not slow)
