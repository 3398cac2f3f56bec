"""Check the clock of a log: where it begins, repeats, runs back, or jumps."""

import numpy as np

from pitotbench.logbook.columns import QUANTITIES, SECONDS_A_DAY
from pitotbench.logbook.draft import Draft
from pitotbench.logbook.flight_parts import BETWEEN_FLIGHTS
from pitotbench.records import BadInputError
from pitotbench.timeline import PAUSE_SAMPLES, stretches
from pitotbench.units import Seconds, from_si, to_si

_FEW = 0.01  # share of time stamps that may repeat
# steps of a coarse clock: for longer it stands still, and a longer step is a pause
_STANDS_STILL = 4.0
# times the most rows of one stamp, to either side, over which the moments are averaged
_NEIGHBORS = 4
_FEWEST_RECORDED = 30  # rows of a recording: a clock that falls for fewer was disturbed
# s, median time between rows: 0.1 Hz is ten times slower than the slowest receiver
_LONGEST_STEP = 10.0
_SHORTEST_STEP = 1.0 / 5000.0  # s: no air data are recorded faster


def check_time(draft: Draft) -> None:
    """Drop a few rows with a repeated time stamp, and spread rows between a coarse clock's stamps.

    Raises BadInputError for a clock that stands still, and for time that runs back.
    """
    if len(draft.rows) < 2:
        raise BadInputError(
            f"the log holds {len(draft.rows)} rows; at least 2 are needed: give the log of a flight"
        )
    column = draft.columns["time"]
    time = draft.channels["time"] = _after_restarts(draft, draft.channels["time"])
    step = np.diff(time, prepend=-np.inf)
    if np.any(step < 0.0):
        i = int(np.argmax(step < 0.0))
        raise BadInputError(
            f"column {column!r}, row {draft.rows[i]}: time runs back from {time[i - 1]:g} to "
            f"{time[i]:g} s; time must increase: sort the rows, or cut the log where its clock was "
            "set"
        )
    repeated = step == 0.0
    if repeated.mean() > _FEW:
        words = (
            f"column {column!r}: {int(repeated.sum())} of {len(time)} time stamps repeat the "
            "one before"
        )
        stamp = float(np.min(step[step > 0.0][1:], initial=np.inf))
        spread = _spread(time, stamp)
        if spread is None:
            raise BadInputError(
                f"{words} ({draft.named(repeated)}); time must increase: write it with more digits"
            )
        draft.channels["time"] = spread
        draft.warnings.append(
            f"{words}: the rows are spread evenly over its steps of {stamp:.3g} s"
        )
    elif repeated.any():
        draft.drop(
            repeated,
            f"column {column!r}: time stamps repeat ({draft.named(repeated)}): those rows are "
            "dropped",
        )


_RESTART = 5.0  # s after the first moment of the file at which a recorder's clock begins again


def _after_restarts(draft: Draft, time: Seconds) -> Seconds:
    """Return the moments of rows whose clock begins anew with each recording, one after another.

    Between two recordings lie twice `BETWEEN_FLIGHTS`: what really passed is not known. A clock
    that falls to another moment than that of its beginning was set, and stays as it is.
    """
    starts = np.flatnonzero(np.diff(time, prepend=-np.inf) < 0.0)
    lengths = np.diff(starts, append=len(time))
    if not len(starts) or np.any(lengths < _FEWEST_RECORDED):
        return time
    # After a single stamp that is wrong the clock jumps back.
    if np.any(np.diff(time)[starts] >= _RESTART) or np.any(
        np.abs(time[starts] - time[0]) > _RESTART
    ):
        return time
    draft.warnings.append(
        f"column {draft.columns['time']!r} begins anew {draft.before(starts)}: the file holds "
        f"{len(starts) + 1} recordings, which are read as flights of their own"
    )
    found = time.copy()
    for start in starts:
        found[start:] += found[start - 1] - found[start] + 2.0 * BETWEEN_FLIGHTS
    return found


def _spread(time: Seconds, stamp: float) -> Seconds | None:
    """Return the moments (n,) [s] of a clock in steps of `stamp` [s], as means of neighbors.

    They stay within a step of the clock, but for what a real recorder lets its stamps tremble, and
    increase strictly. None where the clock stands still for so long that it is no coarse clock.
    """
    first = np.flatnonzero(np.diff(time, prepend=-np.inf))
    longest = int(np.max(np.diff(first, append=len(time))))
    usual = float(np.median(np.diff(time[first]))) * len(first) / len(time)
    if not np.isfinite(stamp) or longest * usual > _STANDS_STILL * stamp:
        return None
    found, reach = time.copy(), longest * _NEIGHBORS
    after = np.flatnonzero(np.diff(time) > max(_STANDS_STILL * stamp, PAUSE_SAMPLES * usual)) + 1
    for rows in stretches(time, after):
        part = time[rows]
        count = min(reach, len(part) - 1)
        # Turned about its ends, the part goes on as it came: a mean at an end is as even as one
        # inside.
        turned = np.r_[
            2.0 * part[0] - part[count:0:-1], part, 2.0 * part[-1] - part[-2 : -count - 2 : -1]
        ]
        sums = np.cumsum(np.r_[0.0, turned - part[0]])
        found[rows] = part[0] + (sums[2 * count + 1 :] - sums[: len(part)]) / (2 * count + 1)
    return found if np.all(np.diff(found) > 0.0) else None


def check_clock(draft: Draft) -> None:
    """Part recordings of several days; their clock goes on some minutes after the last row of each.

    A jump of more than a day is another day, or a clock that was set. Raises BadInputError for rows
    much too far apart or too close, which mean a clock in another unit.
    """
    column, time = draft.columns["time"], draft.channels["time"]
    steps = np.diff(time)
    usual = float(np.median(steps))
    if not _SHORTEST_STEP <= usual <= _LONGEST_STEP:
        raise BadInputError(
            f"column {column!r}: the rows are {usual:.3g} s apart, where {_SHORTEST_STEP:g} to "
            f"{_LONGEST_STEP:g} s are usual{_better_clock(draft, usual)}"
        )
    later = np.flatnonzero(steps > SECONDS_A_DAY) + 1
    if len(later):  # what works on a log counts its clock by the second
        draft.warnings.append(
            f"column {column!r} jumps by more than a day {draft.before(later)}: the file holds "
            f"{len(later) + 1} recordings, which are read as flights of their own"
        )
        excess = np.zeros(len(time))
        excess[later] = steps[later - 1] - 2.0 * BETWEEN_FLIGHTS
        draft.channels["time"] = time - np.cumsum(excess)


def _better_clock(draft: Draft, usual: float) -> str:
    """Return as a hint the unit of time in which rows would come at a flight log's rate."""
    written = float(from_si(usual, draft.suffixes["time"]))
    for suffix in QUANTITIES["time"].suffixes:
        if _SHORTEST_STEP <= float(to_si(written, suffix)) <= 1.0:
            return (
                f": {written:.3g} between rows would fit a column named time_{suffix}: name it so"
            )
    return ": check the unit of the clock"
