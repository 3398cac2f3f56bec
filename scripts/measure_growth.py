"""Measure how the cost grows with samples and with flights; write speed.csv and speed.png.

python scripts/measure_growth.py --flights 10,30,100 --docs docs
"""

import argparse
from itertools import chain
from pathlib import Path

from pitotbench.evidence.pages.growth_page import draw_growth
from pitotbench.evidence.speed import growth
from pitotbench.records.case import Case
from pitotbench.sense import data_system, record
from pitotbench.simulate import fly


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=_sizes, default=growth.SAMPLES, help="rows of the logs, with commas")
    parser.add_argument(
        "--flights", type=_sizes, default=growth.FLIGHTS, help="flights of the campaigns, with commas"
    )
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder to write to (default: docs)")
    options = parser.parse_args()
    costs, log = [], record(fly(Case(maneuver="step_decrease")), data_system("20/1"), 1)
    for cost in chain(growth.costs_by_samples(log, options.samples), growth.costs_by_flights(options.flights)):
        print(cost, flush=True)
        costs.append(cost)
    for job in dict.fromkeys(cost.job for cost in costs):
        print(f"{job}: exponent {growth.exponent([cost for cost in costs if cost.job == job]):.2f}")
    growth.write_costs(costs, options.docs / "speed.csv")
    draw_growth(costs, options.docs / "speed.png")


def _sizes(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split(","))


if __name__ == "__main__":
    main()
