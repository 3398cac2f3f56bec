"""The vector form beside the scalar one, on the same flights, with heading and vanes off by random constants.

    python scripts/verify_forms.py --seeds 100 > docs/forms.md

Prints a page (Markdown) with one line a maneuver and form. About 5 CPU seconds a seed at 50/50 Hz.
"""

import argparse

from pitotbench.evidence.bounds.forms import FIRST_SCORED_SEED, forms_experiment, summarize_forms
from pitotbench.evidence.experiment import Budget, run_experiment
from pitotbench.evidence.pages.measured_pages import forms_page


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--das", default="50/50", help="data system (default: %(default)s)")
    parser.add_argument("--turbulence", default="light", help="none, light or moderate (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=60, help="flights of each maneuver (default: %(default)s)")
    parser.add_argument("--first", type=int, default=FIRST_SCORED_SEED, help="first seed (default: %(default)s)")
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.seeds)
    experiment = forms_experiment(options.turbulence, options.das)
    table = summarize_forms(run_experiment(experiment, seeds, Budget(options.jobs)))
    print(forms_page(table, seeds, {"turbulence": options.turbulence, "das": options.das}), end="")


if __name__ == "__main__":
    main()
