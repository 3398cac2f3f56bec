"""Hold the bounds that others publish against the truth beside ours, on the same flights.

    python scripts/compare_bounds.py --seeds 40 > docs/peers.md

All maneuvers, light turbulence, 20/1 and 50/50 Hz, seeds never used in development.
"""

import argparse
from datetime import UTC, datetime
from pathlib import Path

from pitotbench.campaign.coverage import FIRST_SCORED_SEED
from pitotbench.campaign.flight_store import FlightStore
from pitotbench.campaign.peers import comparison
from pitotbench.show.markdown import markdown_table

HEADING = """# The bound beside its peers

Every row is fitted to the same flights: {seeds} a maneuver (seeds {first} to {last}, {date:%Y-%m-%d}), light
turbulence, random wind and Inverse+ error. `python scripts/compare_bounds.py --seeds {seeds}` repeats it. A 2σ
should hold 95 % of the curve.

- *white residuals*: Cramér-Rao bound of output error, residuals without memory (Klein and Morelli 2006).
- *colored residuals, all lags*: the residual's autocorrelation put into that bound (Morelli and Klein 1997).
- *HAC*: the same with a Bartlett window (Newey and West 1987).
- *1 Hz filter of wind and scale*: an extended Kalman filter as small autopilots run it.
- *per-point spread, fixed speed*: legs or turns at one speed each, bounded by twice their scatter (points, not the
  whole curve; no row where a maneuver holds no speed).
- *pitotbench*: `two_sigma_kt`; the last row is told the noise's levels and length instead of finding them.
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=40, help="flights a maneuver (default: %(default)s)")
    parser.add_argument("--flights", type=Path, help="folder where flights are kept")
    options = parser.parse_args()
    seeds = options.seeds
    table = comparison(seeds, store=FlightStore(options.flights) if options.flights else None)
    last = FIRST_SCORED_SEED + seeds - 1
    print(HEADING.format(seeds=seeds, first=FIRST_SCORED_SEED, last=last, date=datetime.now(UTC)))
    print(markdown_table(table))
    wide = table.pivot_table(index=["maneuver", "das"], columns="bound", values="mean 2σ [kt]")
    ratio = float((wide["pitotbench"] / wide["pitotbench, if the noise were known"]).mean())
    print(f"\nNot knowing the noise widens the bound to {ratio:.2f} times that of the estimator that knows it.")


if __name__ == "__main__":
    main()
