"""The speed ratios that `make lab-bench` prints: CPU time over the CPU time of the same work
without the bench.

Each time is the least of several tries on one thread. On a shared machine absolute times differ
from hour to hour; ratios within one run differ less.
"""

from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pitotbench.records.case import Case
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import CALIBRATION_CHANNELS, LOG_CHANNELS, record
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.sortie import fly
from pitotlab.speed.commands import (
    SHIPPED,
    Line,
    campaign_lines,
    overhead_ratio,
    start_lines,
    step_ratio,
)
from pitotlab.speed.fits import FIT_ROWS, fit_times
from pitotlab.speed.growth import cross_check_growth, peak_megabytes, reading_times, tiled
from pitotlab.tables import write_figures

CROSS_CHECK_ROWS, READ_ROWS = 300_000, 1_000_000


def flight_ratios() -> Iterator[Line]:
    """Measure the steps and the recording of flights; yield a line for each ratio."""
    yield step_ratio().line(f"bare step of our airplane / of JSBSim's {SHIPPED}")
    yield overhead_ratio().line("flight, every channel / bare JSBSim loop")
    for what, channels, limit in (
        ("a log", LOG_CHANNELS, 1.25),
        ("a calibration", CALIBRATION_CHANNELS, inf),
    ):
        ratio = overhead_ratio(channels=channels)
        yield ratio.line(f"flight, channels of {what} / bare JSBSim loop", limit)


def _log() -> FlightLog:
    return record(fly(Case(maneuver="circle")), data_system("100/100"), 1)


def long_log_ratios() -> Iterator[Line]:
    """Measure the cross-check and the reading of long logs; yield a line for each ratio."""
    log = _log()
    growth = cross_check_growth(log, CROSS_CHECK_ROWS // 10, 10)
    yield Line("cross-check a row, 300,000 rows / 30,000 rows", growth, "", 1.30)
    with TemporaryDirectory() as folder:
        path = Path(folder, "long.csv")
        times = reading_times(tiled(log, READ_ROWS), path)
        peak = peak_megabytes(path, "calibrate") / 1e3
    both = times.read + times.calibrate
    yield Line("read 1,000,000 rows of CSV / one pass of Arrow", times.read / times.arrow)
    yield Line("read and calibrate them / one pass of Arrow", both / times.arrow, "", 2.00)
    yield Line("peak memory of reading and calibrating them", peak, " GB", 0.70, figure="memory")


def fit_ratios() -> Iterator[Line]:
    """Measure fits of one log; yield a line for each ratio."""
    log = _log()
    fit = fit_times(log.select(np.arange(min(FIT_ROWS, len(log)))))
    rows = f"{fit.rows:,} rows x 3 outputs, 5 parameters"
    yield Line("SciPy least_squares alone", fit.scipy, " s", note=rows)
    for name, seconds, limit, figure in (
        ("fit with covering bound", fit.covering, 1.0, "fit"),
        ("vector output error", fit.vector, 1.0, ""),
        ("fit with the altitude equation", fit.static, 1.0, ""),
        ("fit without heights", fit.triangle, inf, ""),
    ):
        yield Line(f"{name} / SciPy alone", seconds / fit.scipy, "", limit, figure=figure)
    yield Line("one panel of a page / one fit with covering bound", fit.panel / fit.covering)
    evaluations = fit.covering / fit.evaluation
    yield Line("fit with covering bound / one residual and Jacobian", evaluations, "", 40.0)


PARTS: dict[str, Callable[[], Iterator[Line]]] = {
    "starts": start_lines,
    "flights": flight_ratios,
    "fits": fit_ratios,
    "logs": long_log_ratios,
    "campaigns": campaign_lines,
}


def command(parser: ArgumentParser, words: Sequence[str]) -> int:
    """Print how fast the bench is: CPU times, and their ratios to what the same work costs without
    it.

    CPU seconds of one thread, the least of several tries; campaigns run once. A number above its
    limit is called exceeded, and ends with exit code 1. `--page` writes the numbers that
    docs/how-good-is-it.md quotes.
    """
    add = parser.add_argument
    add("--only", default=",".join(PARTS), help="parts, with commas (default: %(default)s)")
    add("--page", action="store_true", help="write the numbers into the page")
    options = parser.parse_args(words)
    asked = options.only.split(",")
    if unknown := {*asked} - {*PARTS}:
        parser.error(f"--only {', '.join(sorted(unknown))}: known are {', '.join(PARTS)}")
    exceeded = []
    for name in asked:
        for line in PARTS[name]():
            print(line, flush=True)
            exceeded += [line.name] if line.is_exceeded else []
            if options.page and line.figure:
                write_figures({line.figure: f"{line.value:.1f}"})
    if exceeded:
        print(f"exceeded: {len(exceeded)}: {'; '.join(exceeded)}")
    return 1 if exceeded else 0
