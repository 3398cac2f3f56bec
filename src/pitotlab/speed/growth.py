"""Measure how CPU time and memory grow with the samples of a log and with the flights of a
campaign.
"""

import sys
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from subprocess import run
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
from pyarrow.csv import ReadOptions, read_csv

from pitotbench.calibration import calibrate
from pitotbench.calibration.leg_points import cross_check
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.reduction import one_thread
from pitotbench.logbook.formats import write_log
from pitotbench.logbook.reading import read_log
from pitotbench.records.case import Case
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.sortie import fly
from pitotlab.experiment import OUT
from pitotlab.speed.commands import cpu_seconds_of_command, least

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
    """Return the growth of the cross-check's CPU time a row from `rows` to `times` × `rows` rows: 1
    if linear.
    """
    at = CalibrationOptions(
        error_location="static"
    )  # stated, so that the legs and turns alone are timed
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


SAMPLES = (10_000, 30_000, 100_000, 300_000, 1_000_000)
FLIGHTS = (10, 30, 100, 300, 1000)
# Not `ru_maxrss`: a new process begins with that of the process which started it, and this one
# holds long logs.
_PEAK = (
    "import sys, pitotbench as p; log = p.read_log(sys.argv[1]);"
    "len(sys.argv) > 2 and p.calibrate(log);"
    "print(next(line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')))"
)
_TRIES = 2


@dataclass(frozen=True, slots=True)
class Cost:
    """What a job of a size costs: CPU time [s] and, where it was measured, peak memory [MB]."""

    job: str
    size: int
    seconds: float
    megabytes: float | None = None


def costs_by_samples(log: FlightLog, sizes: Sequence[int] = SAMPLES) -> Iterator[Cost]:
    """Yield the cost of reading and of calibrating a log tiled to each number of rows."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "long.csv")
        for size in sizes:
            write_log(tiled(log, size), path)
            long = read_log(path)
            for job, work, argument in (
                ("read", lambda: read_log(path), ()),
                ("calibrate", lambda log=long: calibrate(log), ("calibrate",)),
            ):
                yield Cost(job, size, least(work, _TRIES), peak_megabytes(path, *argument))


def costs_by_flights(sizes: Sequence[int] = FLIGHTS) -> Iterator[Cost]:
    """Yield the cost of a campaign of each number of flights of one short maneuver, without a page."""
    flags = ("campaign", "--maneuver", "rapid_decel", "--das", "20/1", "--no-report", "--jobs", "1")
    for size in sizes:
        with TemporaryDirectory() as folder:
            out = str(Path(folder, "out"))
            seconds = cpu_seconds_of_command(
                ("-m", "pitotbench", *flags, "--seeds", str(size), "--out", out)
            )
        yield Cost("campaign", size, seconds)


def exponent(costs: Sequence[Cost]) -> float:
    """Return the exponent of the power of the size that the CPU times follow, by least squares of
    logarithms.
    """
    slope, _ = np.polyfit(
        np.log([cost.size for cost in costs]), np.log([cost.seconds for cost in costs]), 1
    )
    return float(slope)


def peak_megabytes(path: Path, *argument: str) -> float:
    """Return the peak memory [MB] of a new process that reads a log, and with an argument
    calibrates it.
    """
    done = run(
        [sys.executable, "-c", _PEAK, str(path), *argument],
        check=True,
        capture_output=True,
        text=True,
    )
    return float(done.stdout) / 1024.0


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Measure how the cost grows with samples and with flights. Writes speed.csv."""
    parser.add_argument(
        "--samples", type=_sizes, default=SAMPLES, help="rows of the logs, with commas"
    )
    parser.add_argument(
        "--flights", type=_sizes, default=FLIGHTS, help="flights of the campaigns, with commas"
    )
    parser.add_argument(
        "--out", type=Path, default=OUT, help="folder to write to (default: %(default)s)"
    )
    options = parser.parse_args(words)
    costs, log = [], record(fly(Case(maneuver="step_decrease")), data_system("20/1"), 1)
    for cost in chain(costs_by_samples(log, options.samples), costs_by_flights(options.flights)):
        print(cost, flush=True)
        costs.append(cost)
    for job in dict.fromkeys(cost.job for cost in costs):
        print(f"{job}: exponent {exponent([cost for cost in costs if cost.job == job]):.2f}")
    options.out.mkdir(parents=True, exist_ok=True)
    pd.DataFrame(map(asdict, costs)).to_csv(
        options.out / "speed.csv", index=False, lineterminator="\r\n"
    )


def _sizes(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split(","))
