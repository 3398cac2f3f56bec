"""Print, in one run, how fast the bench is: ratios to what the same work costs without it.

    python scripts/bench.py

Figures of one machine vary with its load; the ratios hold. Single-threaded linear algebra, CPU seconds.
"""

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

from pathlib import Path  # noqa: E402
from tempfile import TemporaryDirectory  # noqa: E402
from time import perf_counter  # noqa: E402

import numpy as np  # noqa: E402

from pitotbench.calibrate.benchmark import fit_times  # noqa: E402
from pitotbench.cli import main as pitotbench  # noqa: E402
from pitotbench.records.case import Case  # noqa: E402
from pitotbench.sense import data_system, record  # noqa: E402
from pitotbench.simulate import fly, overhead_ratio  # noqa: E402

FIT_ROWS = 36_000


def main() -> None:
    print(f"recorded flight / bare JSBSim loop                     {overhead_ratio():6.2f}   (limit 1.35)")
    flight = fly(Case(maneuver="circle"))
    log = record(flight, data_system("100/100"), 1)
    fit = fit_times(log.select(np.arange(min(FIT_ROWS, len(log)))))
    print(f"rows fitted: {fit.rows} x 3 outputs, 5 parameters; SciPy alone {fit.scipy:.3f} s")
    print(f"fit with covering bound / SciPy least_squares alone    {fit.covering / fit.scipy:6.2f}   (limit 1.00)")
    print(f"vector output error / SciPy least_squares alone        {fit.vector / fit.scipy:6.2f}")
    print(f"fit with covering bound / one residual and Jacobian    {fit.covering / fit.evaluation:6.1f}")
    with TemporaryDirectory() as folder:
        begun = perf_counter()
        pitotbench(
            ["campaign", "--maneuver", "all", "--das", "all", "--model", "all", "--out", str(Path(folder, "o"))]
        )
        print(
            f"--maneuver all --das all, all models, one seed         {perf_counter() - begun:6.1f} s (limit 20 s)"
        )


if __name__ == "__main__":
    main()
