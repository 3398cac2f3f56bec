"""Find where a measured log and the simulation disagree, name the missing effect, and show the gap shrink.

python scripts/reconcile.py MEASURED.csv --aircraft navajo [--holdout OTHER.csv] [--json] --out DIR
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "src"))  # this checkout's bench, installed or not

from pitotbench.cli.app import OneLineParser, guarded
from pitotbench.cli.reconcile import add_reconcile

if __name__ == "__main__":
    parser = OneLineParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_reconcile(parser)
    sys.exit(guarded(parser.parse_args()))
