"""`pitotbench aircraft check`: what can be flown with an aircraft."""

import argparse
from pathlib import Path

from pitotbench.cli.app import DONE, NO_ANSWER
from pitotbench.cli.shared_flags import say


def add(parser: argparse.ArgumentParser) -> None:
    """Add the flags of `pitotbench aircraft`."""
    parser.add_argument("action", choices=["check"], help="check: attach the autopilot, and fly what can be flown")
    parser.add_argument(
        "aircraft", metavar="NAME|PATH", help="name in the hangar or in JSBSim's library; JSBSim file or its folder"
    )
    parser.add_argument(
        "--maneuver", default="all", help="maneuvers to fly, with commas (default: the paper's five)"
    )
    parser.add_argument("--seed", type=int, default=1, help="truth seed of the turbulence (default: %(default)s)")
    parser.add_argument("--report", type=Path, help="also write a page with pictures (HTML)")


def run(options: argparse.Namespace) -> int:
    """Check the aircraft and print what was found; return exit code 0, or 3 where no maneuver can be flown."""
    from rich.console import Console

    from pitotbench.bench.inspection import check_aircraft
    from pitotbench.logbook.formats import PAGES, require_file
    from pitotbench.show.inspection import print_check
    from pitotbench.simulation.maneuvers import maneuvers_named

    maneuvers = maneuvers_named(options.maneuver)
    if options.report is not None:
        require_file(options.report, PAGES, [])

    check = check_aircraft(options.aircraft, maneuvers, options.seed, say)
    if options.report is not None:
        from pitotbench.logbook.columns import write_text
        from pitotbench.show.pages import aircraft_page

        write_text(options.report, aircraft_page(check))
    print_check(check, Console(highlight=False, soft_wrap=True))
    return DONE if any(not m.failure for m in check.maneuvers) else NO_ANSWER
