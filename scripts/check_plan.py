"""Hold the planner's forecasts against flights and write docs/plan.md.

    python scripts/check_plan.py --seeds 16 --turbulence light,moderate --out docs

Writes plan.md and plan.png; `--flown FILE.csv` keeps the flown bounds, so that only the forecasts are made again.
"""

import argparse
from pathlib import Path

from pitotbench.evidence.plan_check import check_plan


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=16, help="flights a maneuver (default: %(default)s)")
    parser.add_argument("--turbulence", default="light", help="comma list (default: %(default)s)")
    parser.add_argument("--das", default="20/1,50/50,100/100", help="comma list (default: %(default)s)")
    parser.add_argument("--flown", type=Path, help="CSV file of flown bounds: read where it exists, else written")
    parser.add_argument("--out", type=Path, default=Path("docs"), help="folder (default: %(default)s)")
    options = parser.parse_args()
    table = check_plan(
        options.turbulence.split(","), options.das.split(","), options.seeds, options.out, flown_file=options.flown
    )
    print(table.to_string(index=False, float_format="%.3f"))


if __name__ == "__main__":
    main()
