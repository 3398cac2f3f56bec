"""Hide an effect in a flight, reconcile, hold the answer against the truth: writes docs/reconcile-stories.md.

python scripts/reconcile_stories.py [--only belly_pod,turn_drag] [--out docs] [--reports DIR]
"""

import argparse
import sys
from pathlib import Path

from pitotbench.catalog import Catalog
from pitotbench.evidence.examples import STORIES, work_out, write_examples

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help="names with commas: " + ", ".join(story.name for story in STORIES))
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "docs", help="folder of the page")
    parser.add_argument("--reports", type=Path, help="folder for the full report of each")
    options = parser.parse_args()
    known = Catalog("story", {story.name: story for story in STORIES})
    wanted = options.only.split(",") if options.only else list(known)

    def say(line: str) -> None:
        print(line, file=sys.stderr, flush=True)

    write_examples([work_out(known[name], say) for name in wanted], options.out, options.reports)
