"""`pitotbench plan`: predict the bound of each maneuver, and recommend what to fly."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pitotbench.cli.shared_flags import (
    flag,
    require_known,
    require_page,
    say,
    shared,
    stated_numbers,
    stated_wind,
    tell,
    write_page,
)
from pitotbench.records import SEARCH_FLIGHTS, BadInputError

if TYPE_CHECKING:
    from pitotbench.bench.forecasts import PlanRequest
    from pitotbench.records.case import DataSystem
    from pitotbench.records.forecast import Plan
    from pitotbench.show.reader_units import Units

_PAGE, _CASE = "plan.html", "plan.toml"


FLAGS = (
    flag(
        "--das",
        default="20/1",
        help="data system: 20/1, 50/50, 100/100, any A/G in Hz (default: %(default)s)",
    ),
    flag(
        "--turbulence",
        default="light",
        help="expected: none, light or moderate (default: %(default)s)",
    ),
    *shared("wind", "units", "json"),
    flag(
        "--speeds-kt",
        help="LOW,HIGH: where the curve is wanted [KIAS] (default: the aircraft's, 100,160 for "
        "navajo)",
    ),
    flag(
        "--error-location",
        default="impact",
        help="where the error is expected: static (GPS height shows it), total or impact "
        "(default: %(default)s)",
    ),
    flag(
        "--receiver-height-m",
        help="WHITE,SLOW: 1σ of the height error by GPS, such as 0.3,2 (default: 1.5,0)",
    ),
    flag(
        "--vertical-velocity",
        default="usual",
        help="recorded, missing or usual: from 10 Hz (default: %(default)s)",
    ),
    flag("--minutes", type=float, help="minutes to spend on condition"),
    flag(
        "--want-kt", type=float, help="2σ wanted on the curve [kt]: how many minutes does it take?"
    ),
    flag("--box-nm", type=float, help="side of the square that the maneuver must stay in [nmi]"),
    flag(
        "--maneuver",
        default="every",
        help="a name, a comma list, all (the paper's five) or every (default: %(default)s)",
    ),
    flag(
        "--aircraft",
        default="navajo",
        help="aircraft: a name, or the path of a JSBSim file or folder (default: %(default)s)",
    ),
    flag(
        "--draws",
        type=int,
        default=16,
        help="draws of gusts and sensor noise a maneuver (default: %(default)s)",
    ),
    flag(
        "--search",
        type=int,
        default=SEARCH_FLIGHTS,
        help="flights to improve the best card, 0 for none (default: %(default)s)",
    ),
    flag(
        "--by-hand",
        action="store_true",
        help="plan a card written by hand (for `fixed-speed POINTS.csv`) by --want-kt, --minutes, "
        "--speeds-kt",
    ),
    flag(
        "--sheet",
        type=Path,
        metavar="FILE",
        help="of --by-hand: write its legs as a sheet to fill in (HTML)",
    ),
    flag("--out", type=Path, help="folder for the page (plan.html) and the best case (plan.toml)"),
)


def run(options: argparse.Namespace) -> int:
    """Plan, print, and write the page and the case where asked for."""
    if options.by_hand:
        return _by_hand(options)
    if options.sheet is not None:
        raise BadInputError("--sheet is of a card written by hand: give --by-hand too")
    from pitotbench.bench.planner import plan as plan_flight
    from pitotbench.campaigns.progress import progress
    from pitotbench.records.outputs import require_folder
    from pitotbench.show.plan import plan_json, plan_tree
    from pitotbench.show.reader_units import reader_units

    request, units = request_of(options), reader_units(options.units)
    if options.out is not None:
        require_folder(options.out, (_PAGE, _CASE))
    with progress("flying", len(request.maneuvers) + options.search) as step:
        plan = plan_flight(request, options.search, step)
    tell(options, lambda: plan_json(plan), lambda: plan_tree(plan))
    for path in write_plan(request, plan, options.out, units) if options.out is not None else ():
        say(f"written: {path}")
    return 0


def _by_hand(options: argparse.Namespace) -> int:
    """Print which legs to fly and write down."""
    from pitotbench.calibration.card_plan import plans_by_hand
    from pitotbench.campaigns.flights import wind_toward
    from pitotbench.show.legs import card_sheet, chosen_plan, hand_plan_json, hand_plan_tree
    from pitotbench.units import KNOT

    wanted = options.speeds_kt or "100,160"
    low, high = _speeds(wanted)
    if not 20.0 * KNOT <= low < high <= 400.0 * KNOT:
        raise BadInputError(f"--speeds-kt {wanted}: give LOW,HIGH between 20 and 400 kt")
    require_page(options.sheet)
    if options.want_kt is not None and not options.want_kt > 0.0:
        raise BadInputError(f"--want-kt {options.want_kt:g}: give a bound above zero")
    north, east = (float(part) for part in wind_toward(stated_wind(options))[:2])
    plans = plans_by_hand(low, high, (north, east))
    want = None if options.want_kt is None else options.want_kt * KNOT
    chosen = chosen_plan(plans, want, options.minutes)
    if chosen is not None:
        write_page(options.sheet, lambda: card_sheet(chosen))
    tell(
        options,
        lambda: hand_plan_json(plans, chosen),
        lambda: hand_plan_tree(plans, chosen, want),
    )
    return 0


def request_of(options: argparse.Namespace) -> "PlanRequest":
    """Return the request of the parsed flags. Raises BadInputError for a senseless value."""
    from pitotbench.bench.forecasts import PlanRequest
    from pitotbench.records.case import ERROR_LOCATIONS, Case, PressureErrorSpec
    from pitotbench.simulation.maneuvers import maneuvers_named
    from pitotbench.units import KNOT, NAUTICAL_MILE

    system = _system(options)
    require_known("--error-location", options.error_location, ERROR_LOCATIONS)
    return PlanRequest(
        base=Case(
            aircraft=options.aircraft,
            turbulence=options.turbulence,
            wind=stated_wind(options),
            pressure_error=PressureErrorSpec(location=options.error_location),
            das=system,
        ),
        system=system,
        speeds=None if options.speeds_kt is None else _speeds(options.speeds_kt),
        minutes=options.minutes,
        want=None if options.want_kt is None else options.want_kt * KNOT,
        box=None if options.box_nm is None else options.box_nm * NAUTICAL_MILE,
        maneuvers=maneuvers_named(options.maneuver),
        draws=options.draws,
    )


def _system(options: argparse.Namespace) -> "DataSystem":
    """Return the data system with the receiver that the flags state."""
    from pitotbench.records.case import VERTICAL_VELOCITIES
    from pitotbench.sensing.sampling import data_system

    require_known("--vertical-velocity", options.vertical_velocity, VERTICAL_VELOCITIES)
    system = replace(data_system(options.das), vertical_velocity=options.vertical_velocity)
    if options.receiver_height_m is None:
        return system
    form = "two numbers, WHITE,SLOW, such as 0.3,2"
    white, slow = stated_numbers("--receiver-height-m", options.receiver_height_m, form, 2)
    if not (0.0 <= white < 1e3 and 0.0 <= slow < 1e3):
        raise BadInputError("--receiver-height-m: standard deviations from 0 to 1000 m")
    return replace(system, altitude_noise=white, altitude_drift=slow)


def _speeds(text: str) -> tuple[float, float]:
    from pitotbench.units import KNOT

    form = "two numbers, LOW,HIGH, such as 100,160"
    low, high = stated_numbers("--speeds-kt", text, form, 2)
    return low * KNOT, high * KNOT


def write_plan(request: "PlanRequest", plan: "Plan", folder: Path, units: "Units") -> list[Path]:
    """Write plan.html in the reader's units, and a case that fits as plan.toml; return their paths.

    `pitotbench fly` takes the case.
    """
    from pitotbench.logbook.columns import write_text
    from pitotbench.records.case_file import write_case
    from pitotbench.show.markup import page_of
    from pitotbench.show.plan import plan_tree

    folder.mkdir(parents=True, exist_ok=True)
    page, case = folder / _PAGE, folder / _CASE
    write_text(page, page_of("What to fly", plan_tree(plan), units))
    chosen = plan.improved or plan.best
    if chosen is None:
        return [page]
    flown = replace(
        request.case(chosen.maneuver, dict(chosen.card)), turbulence=request.base.turbulence
    )
    write_text(case, write_case(flown))
    return [page, case]
