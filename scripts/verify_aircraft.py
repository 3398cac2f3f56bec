"""Fly airplanes of JSBSim's library: how well they fly, how often the bound holds the truth, how soon they start.

    python scripts/verify_aircraft.py --seeds 20 --jobs 2 --rows out/aircraft.parquet

Writes aircraft-flights.csv into the folder of --out and prints its tables (Markdown). About 80 CPU seconds a seed;
with --rows, a run that was stopped goes on.
"""

import argparse
from pathlib import Path

from pitotbench.evidence.bounds.aircraft_flights import FOREIGN, fly_foreign, summarize_foreign, time_first_flight
from pitotbench.evidence.experiment import Budget
from pitotbench.evidence.pages.aircraft_tables import first_flights_table, foreign_table
from pitotbench.logbook import atomic

FIRST = 40_001  # a development seed: these flights judge no scored claim


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20, help="flights of each maneuver (default: %(default)s)")
    parser.add_argument("--first", type=int, default=FIRST, help="first seed (default: %(default)s)")
    parser.add_argument("--aircraft", default=",".join(FOREIGN), help="comma list of names (default: %(default)s)")
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    parser.add_argument("--minutes", type=float, help="stop after so many minutes, with whole seeds only")
    parser.add_argument("--rows", type=Path, help="Parquet file of rows flown before (delete it with a change)")
    parser.add_argument("--out", type=Path, default=Path("docs"), help="folder (default: %(default)s)")
    parser.add_argument("--times", action="store_true", help="only time the first flight of each airplane")
    options = parser.parse_args()
    names = tuple(options.aircraft.split(","))
    if options.times:
        print(first_flights_table([time_first_flight(name) for name in names]))
        return
    seeds = range(options.first, options.first + options.seeds)
    rows = fly_foreign(seeds, names, Budget(options.jobs, options.minutes, options.rows))
    table = summarize_foreign(rows)
    options.out.mkdir(parents=True, exist_ok=True)
    with atomic(options.out / "aircraft-flights.csv") as scratch:
        table.to_csv(scratch, index=False, float_format="%.4f", lineterminator="\n")
    print(foreign_table(table))
    for row in rows[rows["failed"] != ""].itertuples():
        print(f"{row.aircraft} {row.maneuver} {row.seed}: {row.failed}")


if __name__ == "__main__":
    main()
