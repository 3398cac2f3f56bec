"""Hide an effect in a flight, reconcile, hold the answer against the truth: writes docs/reconcile-examples.md.

python scripts/reconcile_examples.py [--only belly_pod,turn_drag] [--out docs] [--reports DIR]
"""

import argparse
import sys
from pathlib import Path

from pitotbench.catalog import Catalog
from pitotbench.evidence.examples import EXAMPLES, work_out_examples, write_examples

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help="names with commas: " + ", ".join(example.name for example in EXAMPLES))
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "docs", help="folder of the page")
    parser.add_argument("--reports", type=Path, help="folder for the full report of each")
    options = parser.parse_args()
    known = Catalog("example", {example.name: example for example in EXAMPLES})
    wanted = options.only.split(",") if options.only else list(known)

    def say(line: str) -> None:
        print(line, file=sys.stderr, flush=True)

    write_examples(work_out_examples([known[name] for name in wanted], say), options.out, options.reports)
