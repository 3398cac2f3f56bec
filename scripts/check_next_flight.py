"""Count how often a hidden cause is named by one flight alone, and after the flight that is advised next.

python scripts/check_next_flight.py [--only belly_pod,turn_drag] [--cards circle,rapid_decel] [--varied 2]
"""

import argparse
import sys

from pitotbench.bench.reconcile.next_flight import VARIED
from pitotbench.evidence.next_flight_check import CARDS, CONFUSED, case_lines, cases, try_out

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help="effects to hide, with commas: " + ", ".join(CONFUSED))
    parser.add_argument(
        "--cards", default=",".join(CARDS), help="maneuvers of the first flight (default: %(default)s)"
    )
    parser.add_argument(
        "--varied", type=int, default=VARIED, help="cards whose variants are tried (default: %(default)s)"
    )
    options = parser.parse_args()

    def say(line: str) -> None:
        print(line, file=sys.stderr, flush=True)

    wanted = options.only.split(",") if options.only else CONFUSED
    tried = []
    for row in cases(CONFUSED, options.cards.split(",")):
        if row[0] in wanted:
            tried.append(try_out(*row, say, options.varied))
            print(case_lines(tried[-1:])[0], flush=True)
    print("\n".join(case_lines(tried)))
