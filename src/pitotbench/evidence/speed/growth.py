"""Measure how CPU time and memory grow with the samples of a log and with the flights of a campaign."""

import csv
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from subprocess import run
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from pitotbench.calibrate import calibrate
from pitotbench.evidence.speed.commands import cpu_seconds_of_command
from pitotbench.evidence.speed.scale import tiled
from pitotbench.logbook import read_log, write_log
from pitotbench.records.log import FlightLog

SAMPLES = (10_000, 30_000, 100_000, 300_000, 1_000_000)
FLIGHTS = (10, 30, 100, 300, 1000)
# Not `ru_maxrss`: a new process begins with that of the process which started it, and this one holds long logs.
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
                yield Cost(job, size, min(_seconds(work) for _ in range(_TRIES)), peak_megabytes(path, *argument))


def costs_by_flights(sizes: Sequence[int] = FLIGHTS) -> Iterator[Cost]:
    """Yield the cost of a campaign of each number of flights of one short maneuver, without a page."""
    flags = ("campaign", "--maneuver", "rapid_decel", "--das", "20/1", "--no-report", "--jobs", "1")
    for size in sizes:
        with TemporaryDirectory() as folder:
            out = str(Path(folder, "out"))
            seconds = cpu_seconds_of_command(("-m", "pitotbench", *flags, "--seeds", str(size), "--out", out))
        yield Cost("campaign", size, seconds)


def exponent(costs: Sequence[Cost]) -> float:
    """Return the exponent of the power of the size that the CPU times follow, by least squares of logarithms."""
    slope, _ = np.polyfit(np.log([cost.size for cost in costs]), np.log([cost.seconds for cost in costs]), 1)
    return float(slope)


def _seconds(work: object) -> float:
    begun = process_time()
    work()  # type: ignore[operator]
    return process_time() - begun


def peak_megabytes(path: Path, *argument: str) -> float:
    """Return the peak memory [MB] of a new process that reads a log, and with an argument calibrates it."""
    done = run([sys.executable, "-c", _PEAK, str(path), *argument], check=True, capture_output=True, text=True)
    return float(done.stdout) / 1024.0


def write_costs(costs: Sequence[Cost], path: Path) -> None:
    """Write costs as CSV, a row each."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, [field.name for field in fields(Cost)])
        table.writeheader()
        table.writerows(asdict(cost) for cost in costs)
