"""Examine the time base of a log: missing samples, pauses, and which GPS fixes are new.

A stretch is a part of a log between two breaks. There are two kinds of break:

- A *gap* (`gaps`): at least one sample is missing. A calculation that needs a uniform step, such
as a digital filter, must start anew there.
- A *pause* (`pauses`): the airplane moved unobserved for so long that nothing may be interpolated
across it. A few lost samples are not a pause: a straight line or a spline bridges them.

An *outage* (`in_outage`) is a part of a log in which rows go on, but one sensor repeats its last
sample.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pitotbench.units import Array, Booleans, Seconds

Indices = NDArray[np.intp]

# sample intervals, midway between a step with every sample and one with a sample missing
MISSING = 1.5
# sample intervals: four lost samples in a row are still a fault of the recorder
PAUSE_SAMPLES = 5.0
# s: at a high rate five samples pass before the airplane has moved from a smooth curve
PAUSE_SECONDS = 2.0
OUTAGE_SAMPLES = 2.5  # usual holds of the sensor: one lost sample is no outage, two in a row are
# s: a spline through noisy samples at a high rate leaves the flight path after more
OUTAGE_SECONDS = 0.5
NEARLY_ALL = 0.95  # of the samples: for how long these are held is usual


def interval(time: Seconds) -> float:
    """Return the median time between samples [s], which gaps do not change.

    `time` holds at least two samples.
    """
    return float(np.median(np.diff(time)))


def gaps(time: Seconds) -> Indices:
    """Return the first row after each gap, a step longer than `MISSING` sample intervals."""
    return _after(time, MISSING, 0.0)


def pauses(time: Seconds) -> Indices:
    """Return the first row after each pause.

    A pause is a time step longer than `PAUSE_SAMPLES` sample intervals and than `PAUSE_SECONDS`.
    """
    return _after(time, PAUSE_SAMPLES, PAUSE_SECONDS)


def in_outage(time: Seconds, fresh: Booleans) -> Booleans:
    """Return the rows in which a sensor holds a sample for too long, (n,).

    `fresh` (n,) marks its new samples.

    A hold is too long where it lasts longer than `OUTAGE_SECONDS`, and than `OUTAGE_SAMPLES` times
    what nearly all samples of this sensor are held for. So a slow sensor, one that loses samples at
    random, and a coarse one that often repeats a value have no outage. A pause of the recording is
    none. Rows with a new sample are in no outage. A sensor without two new samples is in outage
    throughout.
    """
    if np.count_nonzero(fresh) < 2:
        return ~fresh
    held = np.zeros(len(time), dtype=np.bool_)
    parts = [(rows, _holds(time[rows], fresh[rows])) for rows in stretches(time, pauses(time))]
    usual = float(
        np.quantile(np.concatenate([lasting[new] for _, (lasting, new) in parts]), NEARLY_ALL)
    )
    for rows, (lasting, _) in parts:
        held[rows] = ~fresh[rows] & (lasting > max(OUTAGE_SAMPLES * usual, OUTAGE_SECONDS))
    return held


def _holds(time: Seconds, fresh: Booleans) -> tuple[Seconds, Indices]:
    """How long the sample of each row of a stretch is held, (n,), and where each hold begins."""
    begins = np.flatnonzero(fresh | (np.arange(len(time)) == 0))
    lengths = np.diff(np.append(time[begins], time[-1]))
    return np.repeat(lengths, np.diff(np.append(begins, len(time)))), begins


def stretches(time: Seconds, breaks: Indices) -> list[slice]:
    """Return the rows of each stretch, which `breaks` from `gaps` or `pauses` begin."""
    ends = [0, *(int(row) for row in breaks), len(time)]
    return [slice(first, end) for first, end in pairwise(ends)]


def stretch_numbers(time: Seconds, breaks: Indices) -> Indices:
    """Return the number of the stretch of each row, counted from 0, (n,)."""
    return np.searchsorted(breaks, np.arange(len(time)), side="right")


def fresh_fixes(marked: Booleans | None, *channels: Array) -> Booleans:
    """Return whether the GPS fix is new in each row, (n,), by some of its channels, (n,) each.

    `marked` is the log's column `gps_fresh`. Without it, a fix is new where a channel differs from
    that of the row before: the recorder repeats the fixes of a slower receiver.
    """
    if marked is not None:
        return marked
    changed = np.any([np.diff(values) != 0.0 for values in channels], axis=0)
    return np.concatenate([[True], changed])


def minutes_text(seconds: float, decimals: int = 0) -> str:
    """Return a moment of a log as minutes and seconds, `12:05`, with decimals `12:05.25`."""
    minutes, seconds_left = divmod(round(seconds, decimals), 60)
    width = 2 + decimals + bool(decimals)
    return f"{minutes:.0f}:{seconds_left:0{width}.{decimals}f}"


def _after(time: Seconds, samples: float, seconds: float) -> Indices:
    if len(time) < 2:
        return np.zeros(0, dtype=np.intp)
    return np.flatnonzero(np.diff(time) > max(samples * interval(time), seconds)) + 1


def nearest(time: Seconds, clock: Seconds) -> Indices:
    """Return the place in `clock`, (m,), that is nearest to each `time`, (n,); both increase."""
    after = np.clip(np.searchsorted(clock, time), 1, len(clock) - 1)
    return after - (time - clock[after - 1] < clock[after] - time)
