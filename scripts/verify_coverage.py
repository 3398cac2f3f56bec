"""Fly the coverage campaign: every maneuver, data system and turbulence, many seeds never used in development.

    python scripts/verify_coverage.py --seeds 400

Writes coverage.csv (one line a cell), coverage.png and coverage.md. About 25 CPU seconds a seed.
"""

import argparse
from pathlib import Path

from pitotbench.evidence.bounds.scorings import SCORINGS
from pitotbench.evidence.bounds.verify import verify
from pitotbench.evidence.experiment import Budget


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=400, help="flights a cell (default: %(default)s)")
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    parser.add_argument("--minutes", type=float, help="stop after so many minutes, with whole seeds only")
    parser.add_argument(
        "--flights", type=Path, help="folder where flights are kept for the next campaign (40 MB a seed)"
    )
    parser.add_argument("--rows", type=Path, help="Parquet file of rows scored before (delete it with a change)")
    parser.add_argument(
        "--scoring",
        default=",".join(SCORINGS),
        help="comma list of questions, with the first (default: %(default)s)",
    )
    parser.add_argument("--out", type=Path, default=Path("out/coverage"), help="folder (default: %(default)s)")
    options = parser.parse_args()
    budget = Budget(options.jobs, options.minutes, options.rows)
    scorings = [SCORINGS[name].name for name in options.scoring.split(",")]
    verify(options.seeds, options.out, budget, scorings, options.flights)


if __name__ == "__main__":
    main()
