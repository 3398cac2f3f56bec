"""Print how fast the bench is: CPU times, and their ratios to what the same work costs without it.

    python scripts/bench.py
    python scripts/bench.py --against ../older/src     # campaigns of an older checkout in turn with this one
    python scripts/bench.py --only reconcile,plan,study --against ../older/src

CPU seconds of one thread, the least of several tries; reconcile, plan and study run once.
"""

import argparse
from pathlib import Path

from pitotbench.evidence.speed import commands, ratios

PARTS = {"starts": commands.start_lines} | ratios.PARTS
COMPARED = commands.COMPARED
USUAL = "starts,flights,fits,logs,campaigns"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", type=Path, help="the src folder of an older checkout")
    known = ", ".join((*PARTS, *COMPARED))
    parser.add_argument("--only", default=USUAL, help=f"parts, with commas, of {known} (default: %(default)s)")
    options = parser.parse_args()
    older = options.against and options.against.resolve()
    asked = options.only.split(",")
    if unknown := {*asked} - {*PARTS, *COMPARED}:
        parser.error(f"--only {', '.join(sorted(unknown))}: known are {known}")
    for name in asked:
        for line in PARTS[name]() if name in PARTS else COMPARED[name](older):
            print(line, flush=True)


if __name__ == "__main__":
    main()
