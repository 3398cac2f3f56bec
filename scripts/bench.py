"""Print, in one run, how fast the bench is: ratios to what the same work costs without it.

    python scripts/bench.py

CPU seconds of one thread, the least of several tries."""

from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

from pitotbench.cli.app import main as pitotbench
from pitotbench.evidence.speed.fit_times import fit_times
from pitotbench.evidence.speed.flight_overhead import overhead_ratio
from pitotbench.evidence.speed.scale import cross_check_growth, reading_times, tiled
from pitotbench.records.case import Case
from pitotbench.sense import data_system, record
from pitotbench.simulate import fly

FIT_ROWS = 36_000
LONG_ROWS = 300_000
EVERYTHING = ["campaign", "--maneuver", "all", "--das", "all", "--model", "all", "--out"]


def main() -> None:
    print(f"recorded flight / bare JSBSim loop                     {overhead_ratio():6.2f}   (limit 1.35)")
    log = record(fly(Case(maneuver="circle")), data_system("100/100"), 1)
    fit = fit_times(log.select(np.arange(min(FIT_ROWS, len(log)))))
    print(f"rows fitted: {fit.rows:,} x 3 outputs, 5 parameters; SciPy alone {fit.scipy:.3f} s")
    print(f"fit with covering bound / SciPy least_squares alone    {fit.covering / fit.scipy:6.2f}   (limit 1.00)")
    print(f"vector output error / SciPy least_squares alone        {fit.vector / fit.scipy:6.2f}   (limit 1.00)")
    evaluations = fit.covering / fit.evaluation
    print(f"fit with covering bound / one residual and Jacobian    {evaluations:6.1f}   (limit 40)")
    growth = cross_check_growth(log, LONG_ROWS // 10, 10)
    print(f"cross-check a row, 300,000 rows / 30,000 rows          {growth:6.2f}   (limit 1.30)")
    with TemporaryDirectory() as folder:
        times = reading_times(tiled(log, LONG_ROWS), Path(folder, "long.csv"))
        both = times.read + times.calibrate
        print(f"read 300,000 rows of CSV / one pass of Arrow's reader  {times.read / times.arrow:6.2f}")
        print(f"read and calibrate them / one pass of Arrow's reader   {both / times.arrow:6.2f}   (limit 2.00)")
        begun = perf_counter()
        pitotbench([*EVERYTHING, str(Path(folder, "all"))])
        print(f"--maneuver all --das all --model all, one seed     {perf_counter() - begun:10.1f} s (limit 20 s)")


if __name__ == "__main__":
    main()
