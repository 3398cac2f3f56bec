"""Measure the CPU time and the memory of long logs."""

import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from subprocess import check_output

import numpy as np
from pyarrow.csv import ReadOptions, read_csv

from pitotbench.calibration import calibrate
from pitotbench.calibration.leg_points import cross_check
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.reduction import one_thread
from pitotbench.logbook.formats import write_log
from pitotbench.logbook.reading import read_log
from pitotbench.records.log import FlightLog
from pitotlab.speed.commands import least

_READ_TRIES = 3


@dataclass(frozen=True, slots=True)
class ReadingTimes:
    """CPU times [s] for one CSV file, each the least of several.

    They are those of one pass of Arrow's reader on one thread, of our reading with all checks, and
    of the calibration of the log. The process is warm. In a new process Arrow's pass takes about
    twice as long, because its memory is not allocated yet.
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
    """Return the growth of the cross-check's CPU time a row to `times` the rows: 1 if linear."""
    at = CalibrationOptions(error_location="static")  # so that legs and turns alone are timed
    short, long = (tiled(log, count) for count in (rows, times * rows))
    with one_thread():
        once, more = (least(partial(cross_check, each, at), _READ_TRIES) for each in (short, long))
        return more / once / times


def reading_times(log: FlightLog, path: Path) -> ReadingTimes:
    """Write a log as CSV to `path`, and time its reading and its calibration."""
    write_log(log, path)
    with path.open("rb") as file:
        above = next(number for number, line in enumerate(file) if not line.startswith(b"#"))
    options = ReadOptions(use_threads=False, skip_rows=above)
    read = read_log(path)
    return ReadingTimes(
        arrow=least(lambda: read_csv(path, read_options=options), _READ_TRIES),
        read=least(lambda: read_log(path), _READ_TRIES),
        calibrate=least(lambda: calibrate(read), _READ_TRIES),
    )


# Not `ru_maxrss`: a new process begins with that of the process which started it, and this one
# holds long logs.
_PEAK = (
    "import sys, pitotbench as p; log = p.read_log(sys.argv[1]);len(sys.argv) > 2 and "
    "p.calibrate(log);print(next(line.split()[1] for line in open('/proc/self/status') if "
    "line.startswith('VmHWM')))"
)


def peak_megabytes(path: Path, *argument: str) -> float:
    """Return the peak memory [MB] of a process that reads, with an argument calibrates, a log."""
    command = [sys.executable, "-c", _PEAK, str(path), *argument]
    return float(check_output(command, text=True)) / 1024.0
