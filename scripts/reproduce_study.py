"""Fly the paper's simulator study again and answer its claims.

    python scripts/reproduce_study.py               # one seed, a look in a minute
    python scripts/reproduce_study.py --seeds 30    # as the paper's claims are answered

Writes report.md and the numbers as Parquet to out/study.
"""

import sys

from this_checkout import run_measurement

if __name__ == "__main__":
    sys.exit(run_measurement("study"))
