"""The speed ratios that `make lab-bench` prints: CPU time over the CPU time of the same work
without the bench.

Each time is the least of several tries on one thread. On a shared machine absolute times differ
from hour to hour; ratios within one run differ less.
"""

from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pitotbench.records.case import Case
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import CALIBRATION_CHANNELS, LOG_CHANNELS, record
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.sortie import fly
from pitotlab.speed.commands import COMPARED, SHIPPED, overhead_ratio, start_lines, step_ratio
from pitotlab.speed.fits import FIT_ROWS, fit_times
from pitotlab.speed.growth import cross_check_growth, peak_megabytes, reading_times, tiled

CROSS_CHECK_ROWS, READ_ROWS = 300_000, 1_000_000


def flight_ratios() -> Iterator[str]:
    """Measure the steps and the recording of flights; yield a line for each ratio."""
    yield f"bare step of our airplane / of JSBSim's {SHIPPED}          {step_ratio()}"
    yield f"flight, every channel / bare JSBSim loop               {overhead_ratio()}"
    logged = overhead_ratio(channels=LOG_CHANNELS)
    yield f"flight, channels of a log / bare JSBSim loop           {logged}   (limit 1.25)"
    needed = overhead_ratio(channels=CALIBRATION_CHANNELS)
    yield f"flight, channels of a calibration / bare JSBSim loop   {needed}"


def _log() -> FlightLog:
    return record(fly(Case(maneuver="circle")), data_system("100/100"), 1)


def long_log_ratios() -> Iterator[str]:
    """Measure the cross-check and the reading of long logs; yield a line for each ratio."""
    log = _log()
    growth = cross_check_growth(log, CROSS_CHECK_ROWS // 10, 10)
    yield f"cross-check a row, 300,000 rows / 30,000 rows          {growth:6.2f}   (limit 1.30)"
    with TemporaryDirectory() as folder:
        path = Path(folder, "long.csv")
        times = reading_times(tiled(log, READ_ROWS), path)
        peak = peak_megabytes(path, "calibrate")
    both = times.read + times.calibrate
    yield f"read 1,000,000 rows of CSV / one pass of Arrow         {times.read / times.arrow:6.2f}"
    yield f"read and calibrate them / one pass of Arrow            {both / times.arrow:6.2f}   (limit 2.00)"
    yield f"peak memory of reading and calibrating them            {peak / 1e3:6.2f} GB   (limit 0.90 GB)"


def fit_ratios() -> Iterator[str]:
    """Measure fits of one log; yield a line for each ratio."""
    log = _log()
    fit = fit_times(log.select(np.arange(min(FIT_ROWS, len(log)))))
    yield f"rows fitted: {fit.rows:,} x 3 outputs, 5 parameters; SciPy alone {fit.scipy:.3f} s"
    yield f"fit with covering bound / SciPy least_squares alone    {fit.covering / fit.scipy:6.2f}   (limit 1.00)"
    yield f"vector output error / SciPy least_squares alone        {fit.vector / fit.scipy:6.2f}   (limit 1.00)"
    yield f"fit with the altitude equation / SciPy alone           {fit.static / fit.scipy:6.2f}   (limit 1.00)"
    yield f"fit without heights / SciPy alone                      {fit.triangle / fit.scipy:6.2f}"
    yield f"one panel of a page / one fit with covering bound      {fit.panel / fit.covering:6.2f}"
    evaluations = fit.covering / fit.evaluation
    yield f"fit with covering bound / one residual and Jacobian    {evaluations:6.1f}   (limit 40)"


DEFAULT_PARTS = "starts,flights,fits,logs,campaigns"
PARTS: dict[str, Callable[[], Iterator[str]]] = {
    "flights": flight_ratios,
    "fits": fit_ratios,
    "logs": long_log_ratios,
}


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Print how fast the bench is: CPU times, and their ratios to what the same work costs without
    it.

    CPU seconds of one thread, the least of several tries; reconcile, plan and study run once.
    `--against` runs campaigns, reconcile, plan and study of an older checkout in turn with this
    one.
    """
    parts = {"starts": start_lines} | PARTS
    parser.add_argument("--against", type=Path, help="the src folder of an older checkout")
    known = ", ".join((*parts, *COMPARED))
    parser.add_argument(
        "--only",
        default=DEFAULT_PARTS,
        help=f"parts of {known}, with commas (default: %(default)s)",
    )
    options = parser.parse_args(words)
    older = options.against and options.against.resolve()
    asked = options.only.split(",")
    if unknown := {*asked} - {*parts, *COMPARED}:
        parser.error(f"--only {', '.join(sorted(unknown))}: known are {known}")
    for name in asked:
        for line in parts[name]() if name in parts else COMPARED[name](older):
            print(line, flush=True)
