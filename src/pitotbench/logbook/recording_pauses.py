"""Pauses of the recording, and the several flights that one log may hold."""

import numpy as np

from pitotbench.logbook.draft import Draft
from pitotbench.records.log import FlightLog
from pitotbench.timeline import Indices, pauses, stretches
from pitotbench.units import Booleans, Seconds

BETWEEN_FLIGHTS = 300.0  # s: in five minutes without a record an airplane lands and takes off, or the wind changes
_SHOWN = 3


def flights_in(log: FlightLog) -> list[FlightLog]:
    """The log cut at every pause of more than five minutes; a list of the log alone where there is none.

    A part of a single row, which is no log, is left out.
    """
    parts = stretches(log.time, flight_breaks(log.time))
    if len(parts) == 1:
        return [log]
    return [log.select(np.arange(p.start, p.stop)) for p in parts if p.stop - p.start > 1]


def flight_breaks(time: Seconds) -> Indices:
    """The first row after each pause of more than `BETWEEN_FLIGHTS`."""
    after = pauses(time)
    return after[np.diff(time)[after - 1] > BETWEEN_FLIGHTS]


def check_pauses(draft: Draft) -> None:
    """Mention pauses of the recording; say it where they are long enough to part two flights.

    A pause at the end of a labeled segment is meant and not mentioned, nor is one that dropped rows made.
    """
    time = draft.channels["time"]
    breaks, after = flight_breaks(time), pauses(time)
    if len(breaks):
        draft.warnings.append(
            f"the log seems to hold {len(breaks) + 1} flights: the recording pauses for more than "
            f"{BETWEEN_FLIGHTS / 60.0:.0f} minutes {_before(draft, breaks)}; a calibration "
            "gives each its own wind"
        )
    short = after[_unmeant(draft, after) & ~np.isin(after, breaks)]
    if len(short):
        longest = float(np.max(np.diff(time)[short - 1]))
        draft.warnings.append(
            f"the recording pauses {_times(len(short))}, for up to {longest:.0f} s, {_before(draft, short)}"
        )


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _before(draft: Draft, after: Indices) -> str:
    rows = ", ".join(str(draft.rows[i]) for i in after[:_SHOWN])
    return f"before row{'s' if len(after) > 1 else ''} {rows}{' and others' if len(after) > _SHOWN else ''}"


def _unmeant(draft: Draft, after: Indices) -> Booleans:
    adjoining: Booleans = np.diff(draft.rows)[after - 1] == 1
    segment = draft.channels.get("segment")
    if segment is None:
        return adjoining
    same: Booleans = segment[after] == segment[after - 1]
    return adjoining & same
