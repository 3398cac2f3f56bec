"""Cut a log into its flights, at pauses and at stops on the ground."""

import numpy as np

from pitotbench.airdata import TAXI
from pitotbench.records.log import FlightLog
from pitotbench.timeline import Indices, pauses, stretches
from pitotbench.units import Seconds

BETWEEN_FLIGHTS = 300.0  # s: in five minutes without a record an airplane lands and takes off, or the wind changes
# s: a pause or a stop on the ground, after which a wind that does not fit the rows before may be
# another one
STOP = 20.0


def flights_in(log: FlightLog) -> list[FlightLog]:
    """Return the log cut at every pause of more than five minutes, as a list of logs.

    A part of a single row, which is no log, is left out.
    """
    return _cut(log, flight_breaks(log.time))


def flights_between_stops(log: FlightLog) -> list[FlightLog]:
    """Return the log cut at every pause and every stop on the ground of at least `STOP`.

    A taxi back to the runway is such a stop. Else as `flights_in`.
    """
    after = pauses(log.time)
    slow = np.hypot(log.velocity_north, log.velocity_east) < TAXI
    begins = np.flatnonzero(slow & ~np.append(True, slow[:-1]))
    ends = np.flatnonzero(slow & ~np.append(slow[1:], True))[-len(begins) :]
    stops = [
        begin
        for begin, end in zip(begins, ends, strict=False)
        if log.time[end] - log.time[begin] >= STOP
    ]
    paused = after[np.diff(log.time)[after - 1] >= STOP]
    return _cut(log, np.union1d(paused, np.array(stops, dtype=np.intp)))


def _cut(log: FlightLog, breaks: Indices) -> list[FlightLog]:
    parts = stretches(log.time, breaks)
    cut = (log.part(np.arange(p.start, p.stop)) for p in parts if p.stop - p.start > 1)
    return [log] if len(parts) == 1 else [*cut]


def flight_breaks(time: Seconds) -> Indices:
    """The first row after each pause of more than `BETWEEN_FLIGHTS`."""
    after = pauses(time)
    return after[np.diff(time)[after - 1] > BETWEEN_FLIGHTS]
