"""Coverage of `--model auto` on curves outside the table of models, beside a fit with Inverse+.

    python scripts/verify_auto.py --maneuver step_decrease,circle --seeds 10

Prints a page (Markdown) with one line a maneuver, truth and model. About 4 CPU seconds a seed and maneuver at
50/50 Hz. The seeds from 200001 on are never used in development.
"""

import argparse

from pitotbench.evidence.bounds.truths_outside import (
    FIRST_DEVELOPMENT_SEED,
    TRUTHS,
    outside_experiment,
    summarize,
)
from pitotbench.evidence.experiment import Budget, run_experiment
from pitotbench.evidence.pages.measured_pages import auto_page


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--maneuver", default="step_decrease,circle", help="comma list (default: %(default)s)")
    parser.add_argument("--das", default="50/50", help="data system (default: %(default)s)")
    parser.add_argument("--turbulence", default="light", help="none, light or moderate (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=10, help="flights of each maneuver (default: %(default)s)")
    parser.add_argument("--first", type=int, default=FIRST_DEVELOPMENT_SEED, help="first seed (default: 1)")
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.seeds)
    experiment = outside_experiment(options.maneuver.split(","), options.turbulence, options.das)
    rows = run_experiment(experiment, seeds, Budget(options.jobs))
    asked = {name: getattr(options, name) for name in ("maneuver", "turbulence", "das")}
    print(auto_page(summarize(rows), list(TRUTHS), seeds, asked), end="")


if __name__ == "__main__":
    main()
