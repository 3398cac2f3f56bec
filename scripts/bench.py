"""Print, in one run, how fast the bench is: ratios to what the same work costs without it.

    python scripts/bench.py
    python scripts/bench.py --against ../older/src     # campaigns of an older checkout in turn with this one

CPU seconds of one thread, the least of several tries.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

from pitotbench.evidence.speed.commands import campaign_lines, start_lines
from pitotbench.evidence.speed.ratios import ratio_lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", type=Path, help="the src folder of an older checkout")
    parser.add_argument("--only", choices=("starts", "ratios", "campaigns"), help="a part of the figures")
    options = parser.parse_args()
    parts: dict[str, Iterator[str]] = {
        "starts": start_lines(),
        "ratios": ratio_lines(),
        "campaigns": campaign_lines(options.against and options.against.resolve()),
    }
    for name, lines in parts.items():
        if options.only in (None, name):
            for line in lines:
                print(line, flush=True)


if __name__ == "__main__":
    main()
