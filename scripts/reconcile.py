"""Find where a measured log and the simulation disagree, name the missing effect, and show the gap shrink.

python scripts/reconcile.py MEASURED.csv --aircraft navajo [--holdout OTHER.csv] [--json] --out DIR
"""

import argparse
import sys

from pitotbench.cli import add_reconcile, guarded

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_reconcile(parser)
    sys.exit(guarded(parser.parse_args()))
