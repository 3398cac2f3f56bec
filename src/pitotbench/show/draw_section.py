"""Draw one part of a page: a maneuver as one data system recorded it, or a log, in words and pictures."""

from collections.abc import Mapping, Sequence

from pitotbench.records.calibration import Calibration
from pitotbench.records.fixed_speed_point import FixedSpeedPoint
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.show.airspeed_card import card_html
from pitotbench.show.calibration_text import calibration_html, condition_lines
from pitotbench.show.error_curves import curve_panels
from pitotbench.show.fixed_speed_tables import points_html
from pitotbench.show.flight_panels import flight_panels
from pitotbench.show.limit import AUTO, Limit
from pitotbench.show.markup import render
from pitotbench.show.residuals import residual_panels
from pitotbench.show.section import Section
from pitotbench.show.short_answer import ShortAnswer, short_answer_of
from pitotbench.show.style import Panel
from pitotbench.units import MetersPerSecond


def flight_section(
    flight: Flight,
    system: str,
    results: Mapping[str, Calibration],
    truth: Mapping[str, MetersPerSecond],
    tolerances: Mapping[str, float] | None,
    points: Sequence[FixedSpeedPoint] = (),
) -> Section:
    """The section of a simulated flight as one data system (`20/1`) recorded it.

    `truth`: true correction [m/s] by model. `tolerances`: see `flight_panels`; None where another section draws the
    flight itself. `points` of fixed-speed methods are drawn over the curve.
    """
    maneuver = flight.case.maneuver.replace("_", " ")
    answer = short_answer_of(next(iter(results.values())), f"{maneuver} {system}")
    flown = [] if tolerances is None else flight_panels(flight, tolerances)
    name = f"{flight.case.maneuver}-{system.replace('/', '-')}"
    html = _html(name, f"{maneuver.capitalize()}, {system} Hz", "", answer, results, truth, flown, points)
    return Section(name, maneuver, system, answer, html)


def log_section(
    name: str,
    log: FlightLog,
    result: Calibration,
    points: Sequence[FixedSpeedPoint] = (),
    limit: Limit | str | None = AUTO,
    lines: Sequence[str] = (),
) -> Section:
    """The section of a log that was read from a file, or of a flight of it; `lines` say which.

    Its group says whether a simulator made the log. `limit` as for `judgments`.
    """
    answer = short_answer_of(result, name)
    rows = " ".join([*(f"{line[0].upper()}{line[1:]}." for line in lines), f"{len(log):,} rows read,"])
    rows += f" {result.samples:,} used."
    anchor = "log-" + "".join(c if c.isalnum() else "-" for c in name)
    html = _html(anchor, name, rows, answer, {result.model: result}, None, [], points, limit)
    origin = "simulated logs" if log.simulated else "measured logs"
    return Section(anchor, origin, name, answer, html)


def _html(
    anchor: str,
    title: str,
    remark: str,
    answer: ShortAnswer,
    results: Mapping[str, Calibration],
    truth: Mapping[str, MetersPerSecond] | None,
    flown: Sequence[Panel],
    points: Sequence[FixedSpeedPoint],
    limit: Limit | str | None = AUTO,
) -> str:
    first = next(iter(results.values()))
    curves = curve_panels(results, truth, points, limit)
    return render(
        "section.html",
        anchor=anchor,
        title=title,
        remark=remark,
        answer=answer,
        flown=flown,
        curve=curves[0],
        conditions=condition_lines(first),
        card=card_html(first.curve, title),
        panels=[*curves[1:], *residual_panels(first)],
        numbers=calibration_html(first) + points_html(points, first.curve),
    )
