"""Fly the paper's simulator study again and answer its claims.

    python scripts/reproduce_study.py                       # one seed, a look in a minute
    python scripts/reproduce_study.py --seeds 30 --docs out/lab   # with study.md and its pictures

Writes report.html and the numbers as Parquet to out/study; with --docs study.md and its pictures
too.
"""

import sys

from this_checkout import run_measurement

if __name__ == "__main__":
    sys.exit(run_measurement("study"))
