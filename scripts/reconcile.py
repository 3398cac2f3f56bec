"""Find where a measured log and the simulation disagree, name the missing effect, and show the gap
shrink.

python scripts/reconcile.py MEASURED.csv --aircraft navajo [--holdout OTHER.csv] [--json] --out DIR
"""

import sys

from this_checkout import run_command

if __name__ == "__main__":
    sys.exit(run_command("reconcile", __doc__))
