"""Measure what campaigns survive and cost, for docs/scale.md. For Linux; `faults` needs the right to mount a disk.

python scripts/verify_campaign.py kills
python scripts/verify_campaign.py resume --flights 1000
"""

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

from pitotbench.evidence.campaigns.command import MEASUREMENTS


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=[*MEASUREMENTS], help="the measurement")
    parser.add_argument("--flights", type=int, help="number of flights or tasks (default: that of docs/scale.md)")
    parser.add_argument("--folder", type=Path, help="folder for the stores, which stay (default: a temporary one)")
    options = parser.parse_args()
    measure, usual = MEASUREMENTS[options.what]
    with TemporaryDirectory(prefix="pitotbench-") as scratch:
        for line in measure(options.folder or Path(scratch), options.flights or usual):
            print(line, flush=True)


if __name__ == "__main__":
    main()
