"""`pitotbench compare`: two versions of an airplane's file side by side."""

import argparse
import sys
from collections.abc import Callable
from math import isfinite
from pathlib import Path
from typing import NamedTuple

from pitotbench.cli.shared_flags import say
from pitotbench.records import BadInputError

BEYOND = 1  # the exit code of a change beyond the tolerance, as of diff and cmp


class Kind(NamedTuple):
    """What can be compared: its name, whether a path is one, and the command for two of it."""

    name: str
    known_by: Callable[[Path], bool]
    compare: Callable[[argparse.Namespace], int | None]


def add(parser: argparse.ArgumentParser) -> None:
    """Add the flags of `pitotbench compare`."""
    parser.add_argument("first", type=Path, metavar="A", help="a JSBSim file (.xml)")
    parser.add_argument("second", type=Path, metavar="B", help="another of the same kind, held against the first")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--report", type=Path, help="also write a page with a picture (HTML)")
    parser.add_argument(
        "--card", metavar="MANEUVER", help="of two airplanes: the card that A flies (default: diagnostic)"
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="PERCENT",
        help="of two airplanes: exit code 1 where a force, a moment, power or mass changes by more than this share "
        "of its largest value in the flight",
    )


def run(options: argparse.Namespace) -> int:
    """Compare what the two arguments are; return exit code 0, or 1 beyond a tolerance.

    Raises BadInputError where they are of two kinds, or of none.
    """
    from pitotbench.logbook.formats import PAGES, require_file

    if options.report is not None:
        require_file(options.report, PAGES, (options.first, options.second))
    kinds = [_kind(path) for path in (options.first, options.second)]
    if kinds[0] is not kinds[1]:
        raise BadInputError(
            f"{options.first.name} is a {kinds[0].name}, {options.second.name} a {kinds[1].name}: give two alike"
        )
    return kinds[0].compare(options) or 0


def _kind(path: Path) -> "Kind":
    for kind in KINDS:
        if kind.known_by(path):
            return kind
    raise BadInputError(f"{path}: give two files of one kind: {', '.join(kind.name for kind in KINDS)}")


def _airplanes(options: argparse.Namespace) -> int:
    from rich.console import Console

    from pitotbench.bench.model_comparison import compare_models
    from pitotbench.logbook.columns import write_text
    from pitotbench.show.columns import json_text
    from pitotbench.show.terms import comparison_json, comparison_page, print_comparison
    from pitotbench.simulation.maneuvers import MANEUVERS

    tolerance = options.tolerance
    if tolerance is not None and not (isfinite(tolerance) and tolerance >= 0.0):
        raise BadInputError(f"--tolerance {tolerance:g}: give a share in percent, 0 or more")
    card = options.card or "diagnostic"
    _ = MANEUVERS[card]  # a spelling mistake is told before anything is flown
    found = compare_models(str(options.first), str(options.second), card, say)
    if options.report is not None:
        write_text(options.report, comparison_page(found))
    if options.json:
        sys.stdout.write(json_text(comparison_json(found)))
    else:
        print_comparison(found, Console(highlight=False, soft_wrap=True))
    return BEYOND if tolerance is not None and 100.0 * found.largest > tolerance else 0


# A new kind is a line here.
KINDS = (Kind("JSBSim file", lambda path: path.suffix.lower() == ".xml", _airplanes),)
