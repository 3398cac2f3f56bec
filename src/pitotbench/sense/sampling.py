"""When a data system samples a flight, and the truth at those instants.

A flight is one or more stretches without gaps (set-up between speeds goes unrecorded). In each the recorder
starts afresh: rows at start + k/air rate, fixes at start + j/GPS rate. Instants that fall between the flight's
samples are interpolated linearly, so that the rates need not divide one another. Before the first sample of
a stretch (a latency asks for it) the first sample is held.
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
    """Instants of a flight: `below` is the sample at or before each, `weight` the share of the next."""

    below: Indices
    weight: Array

    def of(self, channel: Array) -> Array:
        """A channel at these instants; where all fall on samples, nothing is computed."""
        if not self.weight.any():
            return channel[self.below]
        above = np.minimum(self.below + 1, len(channel) - 1)
        return channel[self.below] * (1.0 - self.weight) + channel[above] * self.weight


@dataclass(frozen=True, slots=True)
class Schedule:
    """Rows of the log: their time [s], the instants at which each kind of sensor saw the truth, the row's fix.

    `gps` has an entry a fix, the others an entry a row; `fix` is each row's latest fix, `fresh` true where new.
    """

    time: Seconds
    rows: Instants
    air: Instants
    gps: Instants
    fix: Indices
    fresh: Booleans


def flight_rate(time: Seconds) -> float:
    """The sample rate of a flight [Hz]."""
    return 1.0 / interval(time)


def schedule(
    time: Seconds, air_rate: float, gps_rate: float, air_latency: float = 0.0, gps_latency: float = 0.0
) -> Schedule:
    """When a system of these rates [Hz] and latencies [s] samples a flight with these times [s]."""
    rate = flight_rate(time)
    parts = [_Stretch(rows.start, rows.stop - 1, rate) for rows in stretches(time, gaps(time))]
    rows = [part.grid(air_rate) for part in parts]
    fixes = [part.grid(gps_rate) for part in parts]
    clock = [time[part.first] + row / rate for part, row in zip(parts, rows, strict=True)]
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
        """Sampling instants, in flight samples after the first."""
        step = self.flight_rate / rate
        count = int((self.last - self.first) / step + _SLACK) + 1
        return np.arange(count, dtype=np.float64) * step

    def at(self, position: Array) -> Array:
        """Positions in the flight's arrays, held at the ends of the stretch."""
        return self.first + np.clip(position, 0.0, self.last - self.first)


def _latest(since_start: Seconds, gps_rate: float) -> Indices:
    return np.floor(since_start * gps_rate + _SLACK).astype(np.intp)


def _instants(positions: list[Array]) -> Instants:
    position = np.concatenate(positions)
    below = np.floor(position + _SLACK)
    weight = position - below
    return Instants(below.astype(np.intp), np.where(weight > _SLACK, weight, 0.0))
