"""`pitotbench aircraft`: what can be flown with an aircraft, and its performance in steady flight."""

import argparse
from pathlib import Path

from pitotbench.cli.app import DONE, NO_ANSWER
from pitotbench.cli.shared_flags import require_page, say, tell, write_page
from pitotbench.records import BadInputError

# Flags that only one of the two actions has.
_OF_CHECK = ("maneuver", "seed", "report")
_OF_PERFORMANCE = ("handbook", "json")


def add(parser: argparse.ArgumentParser) -> None:
    """Add the flags of `pitotbench aircraft`."""
    parser.add_argument(
        "action",
        choices=["check", "performance"],
        help="check: attach the autopilot, and fly what can be flown; "
        "performance: stall, climb, cruise, glide and ceiling in steady flight",
    )
    parser.add_argument(
        "aircraft",
        metavar="NAME|PATH",
        help="name in the hangar or in JSBSim's library; JSBSim file or its folder",
    )
    parser.add_argument(
        "--maneuver", help="check: maneuvers to fly, with commas (default: the paper's five)"
    )
    parser.add_argument("--seed", type=int, help="check: truth seed of the turbulence (default: 1)")
    parser.add_argument("--report", type=Path, help="check: also write a page with pictures (HTML)")
    parser.add_argument(
        "--handbook",
        type=Path,
        metavar="TABLE.csv",
        help="performance: published figures to show beside the model's",
    )
    parser.add_argument("--json", action="store_true", help="performance: print one JSON document")


def run(options: argparse.Namespace) -> int:
    """Check an aircraft or find its performance; return exit code 0, or 3 where nothing can be
    flown or found.
    """
    other = _OF_PERFORMANCE if options.action == "check" else _OF_CHECK
    given = [name for name in other if getattr(options, name) not in (None, False)]
    if given:
        raise BadInputError(f"--{given[0]} is no flag of `aircraft {options.action}`; leave it out")
    return (_check if options.action == "check" else _performance)(options)


def _check(options: argparse.Namespace) -> int:
    from pitotbench.bench.inspection import check_aircraft
    from pitotbench.show.inspection import print_check
    from pitotbench.simulation.maneuvers import maneuvers_named

    maneuvers = maneuvers_named(options.maneuver or "all")
    require_page(options.report)
    check = check_aircraft(
        options.aircraft, maneuvers, 1 if options.seed is None else options.seed, say
    )

    def page() -> str:
        from pitotbench.show.pages import aircraft_page  # it loads the drawing library

        return aircraft_page(check)

    write_page(options.report, page)
    tell(options, dict, lambda console: print_check(check, console))
    return DONE if any(not m.failure for m in check.maneuvers) else NO_ANSWER


def _performance(options: argparse.Namespace) -> int:
    from pitotbench.show.inspection import performance_json, print_performance
    from pitotbench.simulation.performance import find_performance

    found = find_performance(options.aircraft, options.handbook)
    tell(
        options, lambda: performance_json(found), lambda console: print_performance(found, console)
    )
    return DONE if found.figures else NO_ANSWER
