"""Fly the paper's simulator study again and answer its claims.

    python scripts/reproduce_study.py                       # one seed, a look in a minute
    python scripts/reproduce_study.py --seeds 30 --docs docs   # what docs/study.md holds

Writes report.html and the numbers as Parquet to out/study; with --docs study.md and its pictures too.
"""

import sys

from this_checkout import run_command

if __name__ == "__main__":
    sys.exit(run_command("study", __doc__))
