"""Fly maneuvers, sense them with data systems, calibrate, and show.

    python scripts/run_campaign.py --maneuver step_decrease --das 20/1
    python scripts/run_campaign.py --maneuver all --das all --model all --turbulence light

See --help for wind, turbulence, pilot, seeds, processes and the output folder.
"""

import sys

from this_checkout import run_command

if __name__ == "__main__":
    sys.exit(run_command("campaign", __doc__))
