"""Find the instants at which a data system samples a flight, and the truth at those instants.

A flight is one or more stretches without gaps, because the set-up between speeds is not recorded. In each stretch
the recorder starts anew: rows at start + k/air rate, fixes at start + j/GPS rate. Instants between two samples of
the flight are interpolated linearly, so the rates need not divide one another. A latency may ask for an instant
before a stretch: there its first sample is used.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.timeline import gaps, interval, stretches
from pitotbench.units import Array, Booleans, Seconds

Indices = NDArray[np.intp]

_SLACK = 1e-6  # samples: instants this close to a sample are on it
_CLOCK_DECIMALS = 6  # the log's clock resolves a microsecond


@dataclass(frozen=True, slots=True)
class Instants:
    """Instants of a flight, (n,): `below` is the sample at or before each, `weight` the share of the next one."""

    below: Indices
    weight: Array

    def of(self, channel: Array) -> Array:
        """Return a channel at these instants, (n,)."""
        # Most systems sample on the flight's samples: then values are copied exactly, without arithmetic.
        if not self.weight.any():
            return channel[self.below]
        above = np.minimum(self.below + 1, len(channel) - 1)
        return channel[self.below] * (1.0 - self.weight) + channel[above] * self.weight


@dataclass(frozen=True, slots=True)
class Schedule:
    """When each row of a log, and each GPS fix, is sampled.

    `time` [s], `rows` and `air` have one entry a row: the stamp, the instant of the row, and the instant of its
    air data, which a latency makes earlier. `gps` has one entry a fix. `fix` (one a row) is the number of the
    latest fix, `fresh` whether that fix is new in this row.
    """

    time: Seconds
    rows: Instants
    air: Instants
    gps: Instants
    fix: Indices
    fresh: Booleans


def flight_rate(time: Seconds) -> float:
    """Return the sample rate of a flight [Hz]."""
    return 1.0 / interval(time)


def schedule(
    time: Seconds, air_rate: float, gps_rate: float, air_latency: float = 0.0, gps_latency: float = 0.0
) -> Schedule:
    """Return when a system of these rates [Hz] and latencies [s] samples a flight of these times [s]."""
    rate = flight_rate(time)
    parts = [_Stretch(rows.start, rows.stop - 1, rate) for rows in stretches(time, gaps(time))]
    rows = [part.grid(air_rate) for part in parts]
    fixes = [part.grid(gps_rate) for part in parts]
    clock = [time[part.first] + row / rate for part, row in zip(parts, rows, strict=True)]
    # Fixes are numbered through the whole flight; `before` is the count of those in earlier stretches.
    before = np.cumsum([0, *(len(fix) for fix in fixes)])
    fix = np.concatenate([_latest(row / rate, gps_rate) + n for row, n in zip(rows, before, strict=False)])
    return Schedule(
        time=np.round(np.concatenate(clock), _CLOCK_DECIMALS),
        rows=_instants([part.at(row) for part, row in zip(parts, rows, strict=True)]),
        air=_instants([part.at(row - air_latency * rate) for part, row in zip(parts, rows, strict=True)]),
        gps=_instants([part.at(row - gps_latency * rate) for part, row in zip(parts, fixes, strict=True)]),
        fix=fix,
        fresh=np.diff(fix, prepend=-1) != 0,
    )


@dataclass(frozen=True, slots=True)
class _Stretch:
    first: int
    last: int
    flight_rate: float

    def grid(self, rate: float) -> Array:
        """Return the sampling instants at a rate [Hz], in samples of the flight after the first."""
        step = self.flight_rate / rate
        count = int((self.last - self.first) / step + _SLACK) + 1
        return np.arange(count, dtype=np.float64) * step

    def at(self, position: Array) -> Array:
        """Return positions in the flight's arrays, kept within the stretch."""
        return self.first + np.clip(position, 0.0, self.last - self.first)


def _latest(since_start: Seconds, gps_rate: float) -> Indices:
    return np.floor(since_start * gps_rate + _SLACK).astype(np.intp)


def _instants(positions: list[Array]) -> Instants:
    position = np.concatenate(positions)
    below = np.floor(position + _SLACK)
    weight = position - below
    return Instants(below.astype(np.intp), np.where(weight > _SLACK, weight, 0.0))
