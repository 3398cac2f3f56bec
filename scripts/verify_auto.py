"""Coverage of `--model auto` on curves outside the table of models, beside a fit with Inverse+.

    python scripts/verify_auto.py --maneuver step_decrease,circle --seeds 10

Prints one line a maneuver, truth and model. About 4 CPU seconds a seed and maneuver at 50/50 Hz.
"""

import argparse
import sys

import pandas as pd

from pitotbench.campaign.coverage import Trial
from pitotbench.campaign.outside import FIRST_DEVELOPMENT_SEED, score_outside, summarize


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--maneuver", default="step_decrease,circle", help="comma list (default: %(default)s)")
    parser.add_argument("--das", default="50/50", help="data system (default: %(default)s)")
    parser.add_argument("--turbulence", default="light", help="none, light or moderate (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=10, help="flights of each maneuver (default: %(default)s)")
    parser.add_argument("--first", type=int, default=FIRST_DEVELOPMENT_SEED, help="first seed (default: 1)")
    options = parser.parse_args()
    rows = [
        row
        for maneuver in options.maneuver.split(",")
        for seed in range(options.first, options.first + options.seeds)
        for row in score_outside(Trial(maneuver, options.turbulence, seed), options.das)
    ]
    print(summarize(pd.DataFrame(rows)).to_string(index=False, float_format="%.3f"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
