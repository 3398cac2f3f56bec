"""Fly the paper's simulator study again and answer its claims.

    python scripts/reproduce_study.py                       # one seed, a look in a minute
    python scripts/reproduce_study.py --seeds 30 --docs docs   # what docs/study.md holds

Writes report.html and the numbers as Parquet to out/study; with --docs study.md and its pictures too.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "src"))  # this checkout's bench, installed or not

from pitotbench.cli.app import OneLineParser, guarded
from pitotbench.evidence.study.command import add_flags


def main() -> int:
    parser = OneLineParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_flags(parser)
    return guarded(parser.parse_args())


if __name__ == "__main__":
    sys.exit(main())
