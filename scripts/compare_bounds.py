"""Hold the bounds that others publish against the truth beside ours, on the same flights.

    python scripts/compare_bounds.py --seeds 40 > docs/peers.md

All maneuvers, light turbulence, 20/1 and 50/50 Hz, seeds never used in development.
"""

import argparse
from pathlib import Path

from pitotbench.campaign.flight_store import FlightStore
from pitotbench.campaign.peers import comparison

HEADING = """# The bound beside its peers

Every row is fitted to the same flights: {seeds} a maneuver, light turbulence, random wind and Inverse+ error.
`python scripts/compare_bounds.py --seeds {seeds}` repeats it. A 2σ should hold 95 % of the curve.
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=40, help="flights a maneuver (default: %(default)s)")
    parser.add_argument("--flights", type=Path, help="folder where flights are kept")
    options = parser.parse_args()
    seeds = options.seeds
    table = comparison(seeds, store=FlightStore(options.flights) if options.flights else None)
    print(HEADING.format(seeds=seeds))
    print("| " + " | ".join(table.columns) + " |\n|" + "---|" * len(table.columns))
    for row in table.itertuples(index=False):
        print("| " + " | ".join(f"{v:.2f}" if isinstance(v, float) else str(v) for v in row) + " |")

    wide = table.pivot_table(index=["maneuver", "das"], columns="bound", values="mean 2σ [kt]")
    ratio = float((wide["pitotbench"] / wide["pitotbench, if the noise were known"]).mean())
    print(f"\nNot knowing the noise widens the bound to {ratio:.2f} times that of the estimator that knows it.")


if __name__ == "__main__":
    main()
