"""The track: a measured log on uniform rows, in stretches between pauses and outages, with the GPS interpolated.

Both sides of every comparison pass the same symmetric filter at the same instants. A comparison must not contain a
hold of the last fix, a window that is not symmetric, or a rectangle rule: each looks like a delay of half a sample
interval.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from pitotbench import air
from pitotbench.channels import CHANNELS, numbers_from
from pitotbench.records.errors import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.timeline import in_outage, interval, pauses, stretches
from pitotbench.units import Array, Booleans, Seconds

Indices = NDArray[np.intp]

GPS_CHANNELS, AIR_CHANNELS = numbers_from("gps"), numbers_from("air")
HALF_WINDOW = 0.2  # s, of the filter
SLOW_GPS = 0.3  # s between fixes from which they are not filtered: the filter would hold one or two of them
SHORTEST = 10.0  # s, of a stretch that is used
FEWEST_FIXES = 4  # of a stretch, for a cubic spline


@dataclass(frozen=True, slots=True)
class Track:
    """Channels by the field names of a FlightLog, each (n,), on uniform rows.

    `start` holds the first row of every stretch and, last, the number of rows. `fix` holds the rows of the GPS
    fixes, `fix_period` and `row_period` are in seconds.
    """

    time: Seconds
    channels: Mapping[str, Array]
    start: tuple[int, ...]
    fix: Indices
    fix_period: float
    row_period: float

    def __getitem__(self, name: str) -> Array:
        return self.channels[name]

    def __contains__(self, name: str) -> bool:
        return name in self.channels

    def replaced(self, changed: Mapping[str, Array]) -> "Track":
        """Return the same rows with some channels replaced."""
        merged = {**self.channels, **changed}
        return Track(self.time, merged, self.start, self.fix, self.fix_period, self.row_period)


def track_of(log: FlightLog, fresh_air: Booleans | None = None) -> Track:
    """Return the track of a log; `fresh_air` is false on rows whose air data only repeat the previous row.

    Lost rows are filled by interpolation. A pause in the recording ends a stretch, and so does an outage of the GPS
    or of the air data, of which no row is used.
    Raises BadInputError where no stretch is long enough to be used, or where the GPS velocity never changes.
    """
    period = interval(log.time)
    fresh = log.fresh_fixes()
    fix_time = log.time[fresh]
    if len(fix_time) < 2:
        raise BadInputError("the log holds fewer than two GPS fixes: nothing can be compared; use another log")
    used = [rows for rows in _observed(log, fresh_air) if _long_enough(log.time[rows])]
    if not used:
        raise BadInputError(
            f"the log holds no stretch of {SHORTEST:.0f} s without a pause or an outage of the GPS or air data: "
            "nothing can be compared"
        )
    fix_period = interval(fix_time)
    times = [_uniform(log.time[rows], period) for rows in used]
    names = [n for n, a in log.channels().items() if a.dtype == np.float64 and n != "time"]
    channels = {
        name: np.concatenate(
            [_regular(log, name, p, t, _new(name, fresh, fresh_air)) for p, t in zip(used, times, strict=True)]
        )
        for name in names
    }
    time = np.concatenate(times)
    start = (0, *np.cumsum([len(t) for t in times]).tolist())
    return Track(time, channels, start, _rows_of(time, fix_time, period), fix_period, period)


def mach_number(track: Track) -> Array:
    """Return the Mach number of the pressures, (n,); impact pressures below 1 Pa count as 1 Pa."""
    return air.mach_from_impact_pressure(np.maximum(track["impact_pressure"], 1.0), track["static_pressure"])


def _observed(log: FlightLog, fresh_air: Booleans | None) -> list[slice]:
    """The rows of each stretch in which GPS and air data are new often enough."""
    held = in_outage(log.time, log.renewed_fixes())
    if fresh_air is not None:
        held = held | in_outage(log.time, fresh_air)
    changes = np.flatnonzero(np.diff(held.astype(np.int8))) + 1
    parts = stretches(log.time, np.union1d(pauses(log.time), changes))
    return [rows for rows in parts if not held[rows.start]]


def _long_enough(time: Seconds) -> bool:
    return len(time) > 1 and bool(time[-1] - time[0] >= SHORTEST)


def _uniform(time: Seconds, period: float) -> Seconds:
    """Uniform times that cover a stretch."""
    count = round(float(time[-1] - time[0]) / period) + 1
    return np.asarray(time[0] + period * np.arange(count))


def _new(name: str, gps: Booleans, air_data: Booleans | None) -> Booleans | None:
    """The rows with a new sample of a channel; None where all rows are new."""
    return gps if name in GPS_CHANNELS else air_data if name in AIR_CHANNELS else None


def _regular(log: FlightLog, name: str, rows: slice, time: Seconds, fresh: Booleans | None) -> Array:
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
