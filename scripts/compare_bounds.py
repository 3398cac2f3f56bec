"""Hold the bounds that others publish against the truth beside ours, on the same flights.

    python scripts/compare_bounds.py --seeds 40 > docs/peers.md

All maneuvers, light turbulence, 20/1 and 50/50 Hz, seeds never used in development.
"""

import argparse
from pathlib import Path

from pitotbench.bench.flight_store import FlightStore
from pitotbench.evidence.bounds.peers import comparison
from pitotbench.evidence.pages.measured_pages import peers_page
from pitotbench.evidence.random_truth import FIRST_SCORED_SEED


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=40, help="flights a maneuver (default: %(default)s)")
    parser.add_argument("--flights", type=Path, help="folder where flights are kept")
    parser.add_argument("--jobs", type=int, help="processes (default: one a core, at most one a maneuver)")
    options = parser.parse_args()
    store = FlightStore(options.flights) if options.flights else None
    table = comparison(options.seeds, store=store, jobs=options.jobs)
    print(peers_page(table, range(FIRST_SCORED_SEED, FIRST_SCORED_SEED + options.seeds)), end="")


if __name__ == "__main__":
    main()
