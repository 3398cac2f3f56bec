"""Print how often fixed-speed points from simulated logs hold the truth.

    python scripts/score_fixed_speed.py --seeds 20 --das 50/50 --turbulence light

Seeds 1 to N are development seeds; winds are drawn up to 25 kt."""

import argparse

from pitotbench.evidence.bounds.fixed_speed_accuracy import score_fixed_speed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10, help="flights a cell (default: %(default)s)")
    parser.add_argument("--das", default="50/50", help="data system (default: %(default)s)")
    parser.add_argument("--turbulence", default="none,light", help="comma list (default: %(default)s)")
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    options = parser.parse_args()
    for turbulence in options.turbulence.split(","):
        for line in score_fixed_speed(turbulence, options.das, range(1, options.seeds + 1), options.jobs):
            print(line, flush=True)


if __name__ == "__main__":
    main()
