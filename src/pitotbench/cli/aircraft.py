"""`pitotbench aircraft`: what can be flown with an aircraft, and its steady performance."""

import argparse
import sys
from pathlib import Path

from pitotbench.cli.shared_flags import (
    DONE,
    NO_ANSWER,
    flag,
    require_page,
    say,
    shared,
    tell,
    write_page,
)
from pitotbench.records import BadInputError

# The flags that each action has.
_FLAGS = {
    "check": ("maneuver", "seed", "report"),
    "performance": ("handbook", "linear", "json", "report"),
    "indicator": ("out", "configuration"),
}


FLAGS = (
    flag(
        "action",
        choices=[*_FLAGS],
        help="check: attach the autopilot, and fly what can be flown; performance: stall, climb, "
        "cruise, glide and ceiling in steady flight, or its modes; indicator: make a handbook's "
        "table of airspeeds the airspeed indicator of a JSBSim airplane",
    ),
    flag(
        "aircraft",
        metavar="NAME|PATH",
        help="name in the hangar or in JSBSim's library; JSBSim file or its folder; indicator: the "
        "table (CSV) with the columns KIAS, KCAS and, where it has several, configuration",
    ),
    flag("--maneuver", help="check: maneuvers to fly, with commas (default: the paper's five)"),
    flag("--seed", type=int, help="check: truth seed of the turbulence (default: 1)"),
    flag("--report", type=Path, help="check, performance: also write a page with pictures (HTML)"),
    flag(
        "--handbook",
        type=Path,
        metavar="TABLE.csv",
        help="performance: published figures to show beside the model's",
    ),
    flag(
        "--linear",
        action="store_true",
        help="performance: instead of the figures, the linear model dx/dt = A x + B u in cruise, "
        "and its modes",
    ),
    flag("--json", action="store_true", help="performance: print one JSON document"),
    *shared("units"),
    flag("--out", type=Path, metavar="FILE.xml", help="indicator: the JSBSim system to write"),
    flag("--configuration", help="indicator: which configuration of a table with several"),
)


def run(options: argparse.Namespace) -> int:
    """Check an aircraft or find its performance; return the exit code.

    The code is 0, or 3 where nothing can be flown or found.
    """
    others = [name for names in _FLAGS.values() for name in names]
    foreign = [name for name in others if name not in _FLAGS[options.action]]
    given = [name for name in foreign if getattr(options, name) not in (None, False)]
    if given:
        raise BadInputError(f"--{given[0]} is no flag of `aircraft {options.action}`; leave it out")
    actions = {"check": _check, "performance": _performance, "indicator": _indicator}
    return actions[options.action](options)


def _check(options: argparse.Namespace) -> int:
    from pitotbench.bench.aircraft_check import check_aircraft
    from pitotbench.show.inspection import check_tree
    from pitotbench.simulation.maneuvers import maneuvers_named

    maneuvers = maneuvers_named(options.maneuver or "all")
    require_page(options.report)
    check = check_aircraft(
        options.aircraft, maneuvers, 1 if options.seed is None else options.seed, say
    )
    tell(options, dict, lambda: check_tree(check), f"What can be flown with {check.aircraft}")
    return DONE if any(not m.failure for m in check.maneuvers) else NO_ANSWER


def _performance(options: argparse.Namespace) -> int:
    from pitotbench.models.linear import linearize
    from pitotbench.models.performance import find_performance
    from pitotbench.show.inspection import performance_json, performance_tree
    from pitotbench.show.linear_model import linear_json, linear_tree

    require_page(options.report, [options.handbook] if options.handbook else [])
    if options.linear:
        if options.handbook:
            raise BadInputError("--handbook has no figure of a linear model; leave it out")
        model = linearize(options.aircraft)
        tell(options, lambda: linear_json(model), lambda: linear_tree(model), "Its linear model")
        return DONE
    found = find_performance(options.aircraft, options.handbook)
    title = f"What {found.aircraft} can do"
    tell(options, lambda: performance_json(found), lambda: performance_tree(found), title)
    return DONE if found.figures else NO_ANSWER


def _indicator(options: argparse.Namespace) -> int:
    from pitotbench.logbook.handbook_table import read_published
    from pitotbench.records.outputs import require_file
    from pitotbench.show.columns import printable
    from pitotbench.show.deliverables import jsbsim_system

    table = Path(options.aircraft)
    curves = {each.configuration: each for each in read_published(table)}
    if options.out is None:
        raise BadInputError("indicator writes a JSBSim system: add --out FILE.xml")
    require_file(options.out, (".xml",), [table])
    name = options.configuration or ("" if "" in curves or len(curves) > 1 else next(iter(curves)))
    if name not in curves:
        known = ", ".join(each for each in curves if each) or "none is named"
        raise BadInputError(
            f"{table}: --configuration names one of its configurations ({known}): an airplane has "
            "one airspeed indicator"
        )
    subject = ", ".join(each for each in (table.stem, name) if each)
    write_page(options.out, lambda: jsbsim_system(curves[name], subject))
    sys.stdout.write(printable(f"written: {options.out}") + "\n")
    return DONE
