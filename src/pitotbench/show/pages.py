"""The pages: a campaign, calibrated logs, an account of a log, a check of an aircraft, a plan."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

from pitotbench.records.aircraft import AircraftCheck, Attached, StepResponse
from pitotbench.records.calibration import AutopilotSettings, Calibration
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.records.outputs import file_name
from pitotbench.records.over_dates import OverDates
from pitotbench.show.calibration import NamedFlight, flight_lines, short_answer_of
from pitotbench.show.calibration_tree import calibration_tree
from pitotbench.show.campaign import ANSWER_COLUMNS, campaign_tree, doubts_of_answers
from pitotbench.show.limits import AUTO, Limit
from pitotbench.show.markup import Section, page_of
from pitotbench.show.over_dates import over_dates_tree
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.record import record_page
from pitotbench.show.renderers import html_of
from pitotbench.show.style import (
    BLUE,
    GRAY,
    ORANGE,
    Mark,
    Panel,
    drawing,
    frame,
    level,
    line,
    panel,
)
from pitotbench.show.tree import (
    NUMBERS,
    SOURCES,
    Code,
    Download,
    Heading,
    Node,
    Sentence,
    Table,
    down_to,
)
from pitotbench.show.words import words
from pitotbench.units import MetersPerSecond

if TYPE_CHECKING:
    import pandas as pd


_MOST_NAMED = 2  # maneuvers that fit into a title


_READING = Heading(
    "How to read this",
    tuple(
        Sentence(text)
        for text in (
            "The error curve is the correction to add to the indicated airspeed to get the "
            "calibrated airspeed. Its ±2σ bound at an airspeed is made to contain the true "
            "correction there in 95 of 100 flights. The level and the length of gusts and the "
            "sensor noise are unknown; they are estimated from the log itself. Use the curve only "
            "between the airspeeds that were flown. The errors at neighboring airspeeds are alike, "
            "so a single flight often has its whole curve inside the bound or much of it outside; "
            "only the mean over many flights is 95 %. The ±2σ band of the whole curve is wider: it "
            "is made to contain the true curve at all airspeeds at once, in 95 of 100 flights.",
            "The 2σ for white residuals is the Cramér-Rao bound for residuals that do not depend "
            "on each other from sample to sample. It is shown for comparison: in moving air it is "
            "far too small. The 2σ of the residual is the scatter between data and model in the "
            "unit of calibrated airspeed, the figure that Martos, Kiszely and Foster (2011) "
            "report. It says how noisy the air and the sensors were, not how well the curve is "
            "known.",
            "The gray samples are what each instant says of the correction once the estimated "
            "wind is taken out. FAR 25.1323(c) limits the installation error to the larger of 3 % "
            "and 5\u00a0kt; the older FAR 23.1323(b) has the same limit in calibrated airspeed. "
            "Both allow an altitude error of 30\u00a0ft for each 100\u00a0kt. Broken black lines, "
            "where they are drawn, show the pressure error that was put into a simulator.",
        )
    ),
    NUMBERS,
)


def campaign_page(
    subtitle: str,
    results: "pd.DataFrame",
    sections: Sequence[Section],
    failures: Sequence[str],
    case: str,
    units: Units = BENCH,
    drawn: Sequence[str] = (),
) -> str:
    """The HTML of a campaign in the reader's units: its tree, and sections of what was drawn.

    `results`, `failures` and `drawn` as for `campaign_tree`; `case`: the TOML of the first flight's
    case.
    """
    names = [str(name).replace("_", " ") for name in results["maneuver"].unique()]
    flown = " and ".join(names) if len(names) <= _MOST_NAMED else f"{len(names)} maneuvers"
    nodes = campaign_tree(results, [section.answer for section in sections], failures, drawn)
    first = Heading("The case of the first flight", (Code(case),), NUMBERS)
    title = f"Pitot-static calibration: {flown}"
    return page_of(title, nodes, units, subtitle, sections, [_READING, first])


def log_page(
    title: str, sections: Sequence[Section], units: Units = BENCH, first: Sequence[Node] = ()
) -> str:
    """Return the HTML of calibrated logs, after what is of all.

    The line below the title says whether they were measured or simulated.
    """
    origins = " and ".join(dict.fromkeys(section.group for section in sections))
    answers = [section.answer for section in sections]
    if len(sections) < 2:  # a single section has its answer and its warnings at its own top
        return page_of(
            title, [], units, f"From a {origins.removesuffix('s')}", sections, [_READING]
        )
    short = Table(ANSWER_COLUMNS, answers, "In short")
    nodes = [*first, short, *doubts_of_answers(answers)]
    return page_of(title, nodes, units, f"From {origins}", sections, [_READING])


def flights_page(
    flights: Sequence[NamedFlight],
    limit: Limit | str | None = AUTO,
    units: Units = BENCH,
    course: OverDates | None = None,
) -> str:
    """Return the HTML of calibrated flights, in the reader's units.

    The course of their correction over dates comes first. `limit` as for `judgments`.
    """
    sections = [
        log_section(
            each.name,
            each.flight.log,
            each.flight.calibration,
            limit,
            flight_lines(each.flight),
            each.settings,
            units,
        )
        for each in flights
    ]
    files = ", ".join(dict.fromkeys(file_name(each.file) for each in flights))
    first = [] if course is None else [over_dates_tree(course)]
    return log_page(f"Pitot-static calibration: {files}", sections, units, first)


def flight_section(
    flight: Flight,
    system: str,
    results: Mapping[str, Calibration],
    truth: Mapping[str, MetersPerSecond],
    tolerances: Mapping[str, float] | None,
    units: Units = BENCH,
) -> Section:
    """Return the section of a simulated flight as one data system (`20/1`) recorded it.

    `truth`: true correction [m/s] by model. `tolerances`: see `flight_panels`; None where another
    section draws the flight itself. The section is in the reader's `units`.
    """
    maneuver = flight.case.maneuver.replace("_", " ")
    answer = short_answer_of(next(iter(results.values())), f"{maneuver} {system}")
    flown = () if tolerances is None else (flight, tolerances)
    name = f"{flight.case.maneuver}-{system.replace('/', '-')}"
    tree = calibration_tree(
        f"{maneuver.capitalize()}, {system} Hz", results, truth=truth, flown=flown
    )
    return Section(name, maneuver, system, answer, _section_html(name, tree, units))


def log_section(
    name: str,
    log: FlightLog | None,
    result: Calibration,
    limit: Limit | str | None = AUTO,
    lines: Sequence[str] = (),
    settings: AutopilotSettings | None = None,
    units: Units = BENCH,
) -> Section:
    """Return the section of a log from a file, or of a flight of it, in the reader's units.

    Its group says whether a simulator made the log. The rest as for `calibration_tree`.
    """
    tree = calibration_tree(
        name, {result.model: result}, limit, lines=lines, log=log, settings=settings
    )
    anchor = "log-" + "".join(c if c.isalnum() else "-" for c in name)
    simulated = (
        log.simulated
        if log
        else any(each.origin == "simulated" for each in result.provenance.inputs)
    )
    origin = "simulated logs" if simulated else "measured logs"
    html = _section_html(anchor, tree, units)
    return Section(anchor, origin, name, short_answer_of(result, name), html)


def calibration_record(
    flights: Sequence[Calibration], limit: Limit | str | None = AUTO, units: Units = BENCH
) -> str:
    """Return the record of one curve as a page of two sheets.

    The curve is from one flight, or from several with a wind each. `limit` as for `judgments`.
    """
    first = flights[0]
    tree = calibration_tree("", {first.model: first}, limit, flights=flights)
    answer = [n for n in down_to(tree.nodes, SOURCES) if not isinstance(n, Heading | Download)]
    sources = (n for n in tree.nodes if isinstance(n, Heading) and n.depth == SOURCES)
    title = "Record of a pitot-static calibration"
    objective = "Find the correction of the airspeed, with a bound."
    parts = [Heading("Answer", tuple(answer)), *sources]
    return record_page(title, objective, first.provenance, parts, units)


def _section_html(anchor: str, tree: Heading, units: Units) -> str:
    title = f"<h2>{escape(tree.text)}</h2>"
    return f'<section class="tree" id="{anchor}">{title}{html_of(tree.nodes, units)}</section>\n'


def aircraft_panels(check: AircraftCheck, units: Units = BENCH) -> list[Panel]:
    """The pictures of the check of an aircraft: its trim, and its answers to steps."""
    quantities = dict.fromkeys(step.quantity for step in check.steps)
    draws = {f"Step of {words(name)}": _response(name, check.steps) for name in quantities}
    if (found := check.attached) is not None:
        levers = [100.0 * lever for lever in found.lever]
        draws = {
            "Throttle in level flight": _trim(found, levers, "throttle in level flight [%]"),
            "Angle of attack in level flight": _trim(
                found, found.alpha_deg, "angle of attack in level flight [°]"
            ),
        } | draws
    return [panel(title, draw, units=units) for title, draw in draws.items()]


def _trim(found: Attached, values: Sequence[float], label: str) -> Mark:
    return drawing(
        line(found.speed_kt, values, marker="o", ms=3.5),
        lambda axes: axes.axvline(found.stall_kt, color=GRAY, lw=1.0, ls="--", label="stall speed"),
        frame("calibrated airspeed [kt]", label),
    )


def _response(quantity: str, every: Sequence[StepResponse]) -> Mark:
    steps = [step for step in every if step.quantity == quantity]
    return drawing(
        *(
            line(step.time, step.change, color=color, label=f"at {step.speed_kt:.0f} KCAS")
            for step, color in zip(steps, (BLUE, ORANGE), strict=False)
        ),
        level(steps[0].step, color=GRAY, lw=1.0, ls="--", label="asked for"),
        frame("time [s]", f"change of {words(quantity)} [{steps[0].unit}]"),
    )
