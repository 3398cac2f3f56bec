"""Coverage of `--model auto` on curves outside the table of models, beside a fit with Inverse+.

    python scripts/verify_auto.py --maneuver step_decrease,circle --seeds 10

Prints a page (Markdown) with one line a maneuver, truth and model. About 4 CPU seconds a seed and maneuver at
50/50 Hz. The seeds from 200001 on are never used in development.
"""

import argparse

import pandas as pd

from pitotbench.evidence.bounds.coverage import Trial
from pitotbench.evidence.bounds.truths_outside import FIRST_DEVELOPMENT_SEED, TRUTHS, score_outside, summarize
from pitotbench.evidence.pages.measured_pages import auto_page


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--maneuver", default="step_decrease,circle", help="comma list (default: %(default)s)")
    parser.add_argument("--das", default="50/50", help="data system (default: %(default)s)")
    parser.add_argument("--turbulence", default="light", help="none, light or moderate (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=10, help="flights of each maneuver (default: %(default)s)")
    parser.add_argument("--first", type=int, default=FIRST_DEVELOPMENT_SEED, help="first seed (default: 1)")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.seeds)
    rows = [
        row
        for maneuver in options.maneuver.split(",")
        for seed in seeds
        for row in score_outside(Trial(maneuver, options.turbulence, seed), options.das)
    ]
    asked = {name: getattr(options, name) for name in ("maneuver", "turbulence", "das")}
    print(auto_page(summarize(pd.DataFrame(rows)), list(TRUTHS), seeds, asked), end="")


if __name__ == "__main__":
    main()
