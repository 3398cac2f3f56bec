"""The pages: a campaign, calibrated logs, the account of a log, the check of an aircraft, a plan."""

from collections.abc import Mapping, Sequence
from html import escape
from math import log
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from pitotbench import air
from pitotbench.records.aircraft import AircraftCheck, Attached, StepResponse
from pitotbench.records.calibration import AutopilotSettings, Calibration
from pitotbench.records.flight import Flight
from pitotbench.records.forecast import Forecast, Plan
from pitotbench.records.log import FlightLog, LogInspection
from pitotbench.show.calibration import NamedFlight, flight_lines, short_answer_of
from pitotbench.show.calibration_tree import calibration_tree
from pitotbench.show.campaign import ANSWER_COLUMNS, campaign_tree, doubts_of_answers
from pitotbench.show.limits import AUTO, Limit
from pitotbench.show.markup import Section, page_of
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.record import record_page
from pitotbench.show.renderers import html_of
from pitotbench.show.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PALE,
    PURPLE,
    RED,
    SKY,
    Mark,
    Panel,
    bars,
    broken,
    dots,
    drawing,
    frame,
    ground,
    level,
    line,
    panel,
    thin,
)
from pitotbench.show.tree import (
    NUMBERS,
    SOURCES,
    Code,
    Download,
    Heading,
    Sentence,
    Table,
    down_to,
)
from pitotbench.show.words import words
from pitotbench.units import DEGREE, FOOT, KNOT, NAUTICAL_MILE, Array, MetersPerSecond

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
            "between the airspeeds that were flown. The errors at neighboring airspeeds are "
            "alike, so a single flight often has its whole curve inside the bound or much of it "
            "outside; only the mean over many flights is 95 %. The ±2σ band of the whole curve is "
            "wider: it is made to contain the true curve at all airspeeds at once, in 95 of 100 "
            "flights.",
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
) -> str:
    """The HTML of a campaign in the reader's units: its tree, and sections of what was drawn.

    `results` and `failures` as for `campaign_tree`; `case`: the TOML of the first flight's case.
    """
    names = [str(name).replace("_", " ") for name in results["maneuver"].unique()]
    flown = " and ".join(names) if len(names) <= _MOST_NAMED else f"{len(names)} maneuvers"
    nodes = campaign_tree(results, [section.answer for section in sections], failures)
    first = Heading("The case of the first flight", (Code(case),), NUMBERS)
    title = f"Pitot-static calibration: {flown}"
    return page_of(title, nodes, units, subtitle, sections, [_READING, first])


def log_page(title: str, sections: Sequence[Section], units: Units = BENCH) -> str:
    """The HTML of calibrated logs; the line below the title says whether they were measured or
    simulated.
    """
    origins = " and ".join(dict.fromkeys(section.group for section in sections))
    answers = [section.answer for section in sections]
    if len(sections) < 2:  # a single section has its answer and its warnings at its own top
        return page_of(
            title, [], units, f"From a {origins.removesuffix('s')}", sections, [_READING]
        )
    nodes = [Table(ANSWER_COLUMNS, answers, "In short"), *doubts_of_answers(answers)]
    return page_of(title, nodes, units, f"From {origins}", sections, [_READING])


def flights_page(
    flights: Sequence[NamedFlight], limit: Limit | str | None = AUTO, units: Units = BENCH
) -> str:
    """The HTML of calibrated flights, in the reader's units. `limit` as for `judgments`."""
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
    files = ", ".join(dict.fromkeys(Path(each.file).name for each in flights))
    return log_page(f"Pitot-static calibration: {files}", sections, units)


# Draw one part of a page: a maneuver as one data system recorded it, or a log, in words and
# pictures.


def flight_section(
    flight: Flight,
    system: str,
    results: Mapping[str, Calibration],
    truth: Mapping[str, MetersPerSecond],
    tolerances: Mapping[str, float] | None,
    units: Units = BENCH,
) -> Section:
    """The section of a simulated flight as one data system (`20/1`) recorded it, in the reader's
    units.

    `truth`: true correction [m/s] by model. `tolerances`: see `flight_panels`; None where another
    section draws the
    flight itself.
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
    """The section of a log that was read from a file, or of a flight of it, in the reader's units.

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
    """The record of one curve, from one flight or from several with a wind each, as a page of two
    sheets. `limit` as for `judgments`.
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
        lambda axes: axes.axvline(found.stall_kt, color=GREY, lw=1.0, ls="--", label="stall speed"),
        frame("calibrated airspeed [kt]", label),
    )


def _response(quantity: str, every: Sequence[StepResponse]) -> Mark:
    steps = [step for step in every if step.quantity == quantity]
    return drawing(
        *(
            line(step.time, step.change, color=color, label=f"at {step.speed_kt:.0f} KCAS")
            for step, color in zip(steps, (BLUE, ORANGE), strict=False)
        ),
        level(steps[0].step, color=GREY, lw=1.0, ls="--", label="asked for"),
        frame("time [s]", f"change of {words(quantity)} [{steps[0].unit}]"),
    )


# The pictures of a log: speeds, height and track over time, the tracks flown, the bound to expect.


def inspection_panels(log: FlightLog, found: LogInspection, units: Units = BENCH) -> list[Panel]:
    """The pictures of a log."""
    speed = np.asarray(air.calibrated_airspeed(log.impact_pressure)) / KNOT
    track = np.arctan2(log.velocity_east, log.velocity_north) / DEGREE % 360.0
    height = np.asarray(air.pressure_altitude(log.static_pressure)) / FOOT
    pictures = {
        "Speeds": drawing(*speed_marks(log)),
        "Pressure altitude": drawing(
            line(*_over_minutes(log, height), lw=1.0), frame("time [min]", "pressure altitude [ft]")
        ),
        "Tracks and airspeeds flown": drawing(
            dots(*thin(track, speed), ms=2.0),
            frame("track [°]", "indicated airspeed [kt]", xlim=(0, 360), xticks=range(0, 361, 60)),
        ),
    }
    if found.expected is not None:
        pictures["Bound to expect in light turbulence"] = drawing(
            line(*(each / KNOT for each in found.expected), marker="o", ms=3.0),
            frame("indicated airspeed [kt]", "2σ of the correction [kt]", ylim=(0.0, None)),
        )
    return [panel(title, draw, units=units) for title, draw in pictures.items()]


def speed_marks(log: FlightLog) -> list[Mark]:
    """The indicated airspeed and the ground speed of a log over its minutes."""
    speed = np.asarray(air.calibrated_airspeed(log.impact_pressure)) / KNOT
    ground = np.hypot(log.velocity_north, log.velocity_east) / KNOT
    return [
        line(*_over_minutes(log, speed), lw=1.0, label="indicated airspeed"),
        line(*_over_minutes(log, ground), lw=1.0, color=ORANGE, label="ground speed"),
        frame("time [min]", "speed [kt]"),
    ]


def _over_minutes(log: FlightLog, values: Array) -> list[Array]:
    """Minutes since the first row and values, thinned, with gaps where recording paused."""
    time, *thinned = broken(*thin(log.time - log.time[0], values))
    return [time / 60.0, *thinned]


# Pictures of a plan: the bound against minutes and against airspeed, and the ground tracks.

_BELOW_DOTS = (
    3.0  # drawing order of names, above lines: the background of a name hides no other card's dot
)
_COLORS = (BLUE, ORANGE, GREEN, RED, PURPLE, SKY)  # of the best maneuvers, which are drawn
_TRACKS = 3
_BOX = np.array([[0, 1, 1, 0, 0], [0, 0, 1, 1, 0]])  # corners of a square, in its sides
_LINE = 0.043  # height of a line of names, as a share of the axis
_NAME_WIDTH, _CLOSE = (
    0.4,
    0.2,
)  # natural logarithms: the width of a name in minutes, the height of close dots
_LARGE, _SQUARE = (7.4, 4.0), (3.8, 3.6)


def front_panels(plan: Plan, units: Units = BENCH) -> list[Panel]:
    """The picture of a plan: the bound over the minutes."""
    return [
        panel(
            "How well the curve is known, against minutes",
            lambda axes: draw_front(axes, plan),
            "A dot is a card flown once, with its 1σ between flights. The line from a dot is the "
            "same card flown repeatedly. Black: the Pareto front, the smallest bound that whole "
            "cards reach in so many minutes.",
            size=_LARGE,
            units=units,
        )
    ]


def plan_panels(plan: Plan, units: Units = BENCH) -> list[Panel]:
    """What stands below the bound over the minutes: the bound by airspeed, and the ground."""
    best = zip(plan.forecasts, _COLORS, strict=False)
    named = [(each, color, words(each.maneuver)) for each, color in best]
    curves = drawing(
        *(line(f.airspeeds / KNOT, f.two_sigma / KNOT, color=c, label=n) for f, c, n in named),
        frame("indicated airspeed [kt]", "±2σ of the curve [kt]", ylim=(0.0, None)),
    )
    tracks = drawing(
        *(
            line(east - np.nanmin(east), north - np.nanmin(north), color=color, lw=1.0, label=name)
            for each, color, name in named[:_TRACKS]
            for north, east in [each.track / NAUTICAL_MILE]  # from the corner of the axes on
        ),
        *(
            line(side * _BOX[0], side * _BOX[1], color=PALE, lw=2.0, label="box")
            for side in ([] if plan.box is None else [plan.box / NAUTICAL_MILE])
        ),
        frame("east [nmi]", "north [nmi]"),
        ground,
    )
    flown = f"The {len(named)} best maneuvers, each flown once."
    covered = (
        "The best maneuvers in the expected wind. Recorded parts only: the set-ups need more "
        "ground."
    )
    return [
        panel("±2σ of the curve, by airspeed", curves, flown, units=units),
        panel("Ground covered", tracks, covered, size=_SQUARE),
    ]


def front(forecasts: Sequence[Forecast], last: float) -> list[tuple[float, float]]:
    """Minutes and ±2σ [m/s] of the Pareto front, up to `last` minutes, for cards flown once or
    more.

    No other choice takes fewer minutes and has a smaller bound.
    """
    choices = [
        (times * each.minutes, each.mean / times**0.5)
        for each in forecasts
        for times in range(1, int(last / each.minutes) + 1)
    ]
    best: list[tuple[float, float]] = []
    for minutes, bound in sorted(choices):
        if not best or bound < best[-1][1]:
            best.append((minutes, bound))
    return best


def draw_front(axes: Axes, plan: Plan) -> None:
    """Draw ±2σ [kt] against minutes, both logarithmic: a line of slope −½ is a card flown
    repeatedly.
    """
    shown = [*plan.forecasts, *([plan.improved] if plan.improved else [])]
    last = max(1.6 * max(each.minutes for each in shown), 1.1 * (plan.minutes or 0.0))
    for each in shown:
        minutes = np.geomspace(each.minutes, last, 20)
        color, marker, size = _look(plan, each)
        bounds = [each.mean_in(m) / KNOT for m in minutes]
        line(minutes, bounds, color=color, lw=0.6, alpha=0.5)(axes)
        bars(
            each.minutes, each.mean / KNOT, each.spread / KNOT,
            fmt=marker, ms=size, color=color, elinewidth=0.8, zorder=_BELOW_DOTS + 1.0,
        )(axes)  # fmt: skip
    edge = front(shown, last)
    corners = np.transpose([*edge, (last, edge[-1][1])]) / [[1.0], [KNOT]]
    axes.step(*corners, where="post", color=INK, lw=1.2, label="Pareto front")
    if plan.want is not None:
        wanted = plan.want / KNOT
        level(wanted, color=GREEN, ls="--", lw=1.4, label=f"wanted, {wanted:g} kt")(axes)
    if plan.minutes is not None:
        axes.axvline(plan.minutes, color=ORANGE, ls="--", label=f"{plan.minutes:g} min")
    frame(
        "time recorded [min]",
        "mean ±2σ of the curve [kt]",
        xscale="log",
        yscale="log",
        xlim=(0.62 * min(each.minutes for each in shown), last),
    )(axes)
    _name_dots(axes, plan, shown)
    for axis in (axes.xaxis, axes.yaxis):  # plain numbers on logarithmic axes
        low, high = axis.get_view_interval()
        ticks = [m * 10.0**d for d in range(-4, 4) for m in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)]
        inside = [t for t in ticks if low <= t <= high]
        axis.set_ticks(inside, [f"{t:g}" for t in inside])
        axis.set_ticks([], minor=True)


def _look(plan: Plan, each: Forecast) -> tuple[str, str, float]:
    """Color, marker and size of a card's dot."""
    if each is plan.improved:
        return RED, "*", 10.0
    return (BLUE, "o", 6.0) if each is plan.best else (GREY, "o", 5.0)


def _name_dots(axes: Axes, plan: Plan, shown: Sequence[Forecast]) -> None:
    """Write the names next to the dots; to the right where another dot is close on the left, and
    pushed apart.
    """
    low, high = axes.get_ylim()
    line = (low / high) ** _LINE  # the axis is logarithmic: a line down is a ratio
    lowest: list[
        tuple[bool, float, float]
    ] = []  # side, minutes and height of the names written so far
    for each in sorted(shown, key=lambda f: -f.mean):
        apart = [
            (log(each.minutes / other.minutes), abs(log(each.mean / other.mean))) for other in shown
        ]
        right = any(0.0 < before < _NAME_WIDTH and above < _CLOSE for before, above in apart)
        near = [
            h for side, m, h in lowest if side == right and abs(log(m / each.minutes)) < _NAME_WIDTH
        ]
        height = min([each.mean / KNOT, *(line * h for h in near)])
        lowest.append((right, each.minutes, height))
        axes.annotate(
            each.maneuver.replace("_", " ") + (", improved" if each is plan.improved else ""),
            (each.minutes, each.mean / KNOT),
            xytext=((1.03 if right else 0.97) * each.minutes, height),
            ha="left" if right else "right",
            va="center",
            fontsize=8,
            bbox={"facecolor": "white", "alpha": 0.9, "linewidth": 0.0, "pad": 0.5},
            color=_look(plan, each)[0] if each in (plan.best, plan.improved) else INK,
            zorder=_BELOW_DOTS,
        )
