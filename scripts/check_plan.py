"""Hold the planner's forecasts against flights and write docs/plan.md.

    python scripts/check_plan.py --seeds 16 --turbulence light,moderate --out docs

Writes plan.md and plan.png; `--rows FILE.parquet` keeps the flown bounds: a check cut short goes on, and a second
one makes only the forecasts again. Flights with a static error come first; `--height-only` prints these alone.
"""

import argparse
from pathlib import Path

from pitotbench.evidence.experiment import Budget
from pitotbench.evidence.height_check import check_forecasts_with_height
from pitotbench.evidence.plan_check import check_plan


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=16, help="flights a maneuver (default: %(default)s)")
    parser.add_argument("--turbulence", default="light", help="comma list (default: %(default)s)")
    parser.add_argument("--das", default="20/1,50/50,100/100", help="comma list (default: %(default)s)")
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    parser.add_argument("--rows", type=Path, help="Parquet file of flown bounds (delete it with a new calibrator)")
    parser.add_argument("--out", type=Path, default=Path("docs"), help="folder (default: %(default)s)")
    parser.add_argument("--height-seeds", type=int, default=12, help="with a static error (default: %(default)s)")
    parser.add_argument("--height-only", action="store_true", help="end after the flights with a static error")
    options = parser.parse_args()
    heights = check_forecasts_with_height(range(1, options.height_seeds + 1), Budget(options.jobs))
    print(heights.to_string(index=False, float_format="%.3f"), flush=True)
    if options.height_only:
        return
    turbulences, systems = options.turbulence.split(","), options.das.split(",")
    budget = Budget(options.jobs, rows=options.rows)
    table = check_plan(turbulences, systems, options.seeds, options.out, budget, heights)
    print(table.to_string(index=False, float_format="%.3f"))


if __name__ == "__main__":
    main()
