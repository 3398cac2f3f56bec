"""Measure the CPU time for a long log: the cross-check for each row, and reading relative to Arrow's CSV reader."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import numpy as np
from pyarrow import csv

from pitotbench.calibrate import CalibrationOptions, calibrate
from pitotbench.calibrate.gps_legs.leg_points import cross_check
from pitotbench.calibrate.one_thread import one_thread
from pitotbench.logbook import read_log, write_log
from pitotbench.records.log import FlightLog

_TRIES = 3


@dataclass(frozen=True, slots=True)
class ReadingTimes:
    """CPU times [s] for one CSV file, each the least of several.

    They are those of one pass of Arrow's reader on one thread, of our reading with all checks, and of the
    calibration of the log. The process is warm. In a new process Arrow's pass takes about twice as long, because
    its memory is not allocated yet.
    """

    arrow: float
    read: float
    calibrate: float


def tiled(log: FlightLog, rows: int) -> FlightLog:
    """Return a log that repeats the rows of another one without a pause, up to a number of rows."""
    turn, row = np.divmod(np.arange(rows), len(log))
    channels = {name: values[row] for name, values in log.channels().items()}
    step = float(np.median(np.diff(log.time)))
    channels["time"] = channels["time"] + turn * (log.time[-1] - log.time[0] + step)
    return FlightLog(**channels, header=log.header)


def cross_check_growth(log: FlightLog, rows: int, times: int) -> float:
    """Return the growth of the cross-check's CPU time a row from `rows` to `times` × `rows` rows: 1 if linear."""
    at = CalibrationOptions(error_location="static")  # stated, so that the legs and turns alone are timed
    short, long = (tiled(log, count) for count in (rows, times * rows))
    with one_thread():
        return _least(lambda: cross_check(long, at)) / _least(lambda: cross_check(short, at)) / times


def reading_times(log: FlightLog, path: Path) -> ReadingTimes:
    """Write a log as CSV to `path`, and time its reading and its calibration."""
    write_log(log, path)
    with path.open("rb") as file:
        above = next(number for number, line in enumerate(file) if not line.startswith(b"#"))
    options = csv.ReadOptions(use_threads=False, skip_rows=above)
    read = read_log(path)
    return ReadingTimes(
        arrow=_least(lambda: csv.read_csv(path, read_options=options)),
        read=_least(lambda: read_log(path)),
        calibrate=_least(lambda: calibrate(read)),
    )


def _least(work: Callable[[], object]) -> float:
    times = []
    for _ in range(_TRIES):
        begun = process_time()
        work()
        times.append(process_time() - begun)
    return min(times)
