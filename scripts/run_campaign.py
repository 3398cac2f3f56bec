"""Fly maneuvers, sense them with data systems, calibrate, and show.

    python scripts/run_campaign.py --maneuver step_decrease --das 20/1
    python scripts/run_campaign.py --maneuver all --das all --model all --turbulence light

See --help for wind, turbulence, pilot, seeds, processes and the output folder.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "src"))  # this checkout's bench, installed or not

from pitotbench.cli.app import OneLineParser, add_campaign, guarded


def main() -> int:
    parser = OneLineParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_campaign(parser)
    return guarded(parser.parse_args())


if __name__ == "__main__":
    sys.exit(main())
