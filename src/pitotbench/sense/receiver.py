"""Add the slow part of a receiver's height error: satellite geometry and the ionosphere change over minutes."""

from dataclasses import replace
from itertools import accumulate

import numpy as np

from pitotbench.records.case import DataSystem
from pitotbench.records.flight import Flight
from pitotbench.sense.sensor import noise_stream
from pitotbench.timeline import gaps, interval, stretches
from pitotbench.units import Array, Meters, Seconds


def with_height_error(flight: Flight, das: DataSystem, seed: int) -> Flight:
    """Return the flight with the slow error in its altitude; the same flight where the receiver has none."""
    if das.altitude_drift == 0.0 or "altitude" not in flight.channels:
        return flight
    stream = noise_stream(seed, "altitude_drift", das)
    error = slow_error(flight["time"], das.altitude_drift, das.altitude_drift_time, stream)
    return replace(flight, channels={**flight.channels, "altitude": flight["altitude"] + error})


def slow_error(time: Seconds, deviation: float, memory: float, stream: np.random.Generator) -> Meters:
    """Return a stationary first-order Gauss-Markov process at increasing times [s], (n,).

    `deviation` is its standard deviation and gives the unit, `memory` [s] its correlation time. Recorded time may
    have gaps, in which the process continues.
    """
    new = stream.standard_normal(len(time))
    parts, last = [], 0.0
    for rows in stretches(time, gaps(time)):
        gap = np.inf if rows.start == 0 else float(time[rows.start] - time[rows.start - 1])
        parts.append(_run(new[rows], last, gap, interval(time), memory))
        last = float(parts[-1][-1])
    return np.asarray(deviation * np.concatenate(parts))


def _run(new: Array, before: float, gap: float, step: float, memory: float) -> Array:
    """Return one stretch of unit deviation from such white noise; `before` is the value a gap [s] ago."""
    kept, across = np.exp(-step / memory), np.exp(-gap / memory)
    drive = np.sqrt(1.0 - kept**2) * new
    drive[0] = np.sqrt(1.0 - across**2) * new[0] + across * before
    # A loop of Python takes 2 ms a flight; SciPy's filter takes less, but half a second to load.
    share = float(kept)
    return np.array(list(accumulate(drive.tolist(), lambda value, more: share * value + more)))
