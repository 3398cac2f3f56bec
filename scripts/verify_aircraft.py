"""Fly airplanes of JSBSim's library: how well they fly, how often the bound holds the truth, how soon they start.

    python scripts/verify_aircraft.py --seeds 20 --jobs 2 --rows out/aircraft.parquet

Writes aircraft-flights.csv and prints its table. About 80 CPU seconds a seed; with --rows a stopped run goes on.
"""

import argparse
from pathlib import Path

from pitotbench.evidence.bounds.aircraft_command import time_first_flights, verify_aircraft
from pitotbench.evidence.bounds.aircraft_flights import FOREIGN
from pitotbench.evidence.experiment import Budget


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20, help="flights of each maneuver (default: %(default)s)")
    parser.add_argument("--first", type=int, default=40_001, help="first seed (default: %(default)s, development)")
    parser.add_argument("--aircraft", default=",".join(FOREIGN), help="comma list (default: %(default)s)")
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    parser.add_argument("--minutes", type=float, help="stop after so many minutes, with whole seeds only")
    parser.add_argument("--rows", type=Path, help="Parquet file of rows flown before (delete it with a change)")
    parser.add_argument("--out", type=Path, default=Path("docs"), help="folder (default: %(default)s)")
    parser.add_argument("--times", action="store_true", help="only time the first flight of each airplane")
    options = parser.parse_args()
    names = tuple(options.aircraft.split(","))
    if options.times:
        print(time_first_flights(names))
        return
    seeds = range(options.first, options.first + options.seeds)
    budget = Budget(options.jobs, options.minutes, options.rows)
    print(verify_aircraft(seeds, names, budget, options.out))


if __name__ == "__main__":
    main()
