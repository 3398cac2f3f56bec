"""The vector form beside the scalar one, on the same flights, with heading and vanes off by random constants.

    python scripts/verify_forms.py --seeds 100 > docs/forms.md

Prints a page (Markdown) with one line a maneuver and form. About 5 CPU seconds a seed at 50/50 Hz.
"""

import argparse
import os
import sys
from datetime import UTC, datetime

import pandas as pd
from rich.console import Console
from rich.progress import track

from pitotbench.campaign.coverage import Trial
from pitotbench.campaign.forms import FIRST_SCORED_SEED, score_forms, summarize_forms
from pitotbench.campaign.run import executor_for
from pitotbench.show.markdown import markdown_table
from pitotbench.simulate import PAPER_MANEUVERS

PAGE = """# Scalar and vector form

Both forms on the same flights: seeds {first} to {last}, {turbulence} turbulence, {das} Hz, random wind and Inverse+
error, {date:%Y-%m-%d}. Heading is off by a random constant (1° standard deviation), each vane by another (0.5°).
A 2σ should hold 95 %. [method.md](method.md) says what the vector form adds.
`python scripts/verify_forms.py --seeds {count}` repeats it.
"""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--das", default="50/50", help="data system (default: %(default)s)")
    parser.add_argument("--turbulence", default="light", help="none, light or moderate (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=60, help="flights of each maneuver (default: %(default)s)")
    parser.add_argument("--first", type=int, default=FIRST_SCORED_SEED, help="first seed (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes (default: one a core)")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.seeds)
    flown = [Trial(m, options.turbulence, s) for s in seeds for m in PAPER_MANEUVERS]
    systems = [options.das] * len(flown)
    with executor_for(options.jobs, None) as pool:
        results = (map if pool is None else pool.map)(score_forms, flown, systems)
        quiet = not sys.stderr.isatty()
        done = track(results, "flights", len(flown), console=Console(stderr=True), disable=quiet)
        rows = [row for found in done for row in found]
    said = {"turbulence": options.turbulence, "das": options.das, "count": len(seeds), "date": datetime.now(UTC)}
    print(PAGE.format(first=seeds[0], last=seeds[-1], **said))
    print(markdown_table(summarize_forms(pd.DataFrame(rows))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
