"""The tree of a calibration: what it found, what to doubt, what it rests on. One for all voices."""

from collections.abc import Mapping, Sequence
from typing import Any

from pitotbench.records.calibration import AutopilotSettings, Calibration
from pitotbench.records.log import FlightLog
from pitotbench.show.calibration import (
    CURVE_COLUMNS,
    GLANCE_COLUMNS,
    assumption_lines,
    card_csv,
    curve_points,
    departure_line,
    doubts_of,
    fit_lines,
    glance_points,
    handbook_lines,
    is_doubt,
    location_lines,
    parameter_lines,
    part_lines,
    share_lines,
    short_answer_of,
    wind_lines,
)
from pitotbench.show.deliverables import SETTING_COLUMNS, settings_lines
from pitotbench.show.legs import point_columns
from pitotbench.show.limits import AUTO, Limit, judgments
from pitotbench.show.record import (
    CHECK_COLUMNS,
    WIND_COLUMNS,
    conditions_of,
    flights_checks,
    winds_of,
)
from pitotbench.show.tree import (
    NUMBERS,
    SOURCES,
    Doubt,
    Download,
    Figure,
    Heading,
    Node,
    Notice,
    Sentence,
    Table,
)
from pitotbench.units import MetersPerSecond

_MOST_WINDS = 12  # rows, so that the record of a long flight keeps to two pages


def calibration_tree(
    subject: str,
    results: Mapping[str, Calibration],
    limit: Limit | str | None = AUTO,
    *,
    lines: Sequence[str] = (),
    log: FlightLog | None = None,
    settings: AutopilotSettings | None = None,
    flights: Sequence[Calibration] = (),
    truth: Mapping[str, MetersPerSecond] | None = None,
    flown: tuple[Any, ...] = (),
) -> Heading:
    """The tree of the first of some `results` by model; the others are drawn beside it.

    `limit` as for `judgments`. `lines` say which flight of a log it is; with the `log` the parts
    that were used are drawn. `flights`: those that share the curve, where there are several.
    `truth`: the true correction [m/s] by model. `flown`: a simulated flight, and its
    tolerances as for `flight_panels`.
    """
    name, result = next(iter(results.items()))
    true = None if truth is None else truth[name]
    answer, curve, doubts = short_answer_of(result, subject), result.curve, doubts_of(result)
    first = [Doubt(text, first=True) for text in doubts[:1]]
    pictures = Figure("pitotbench.show.flights.flight_panels", flown)
    sentences = [answer.correction_sentence, answer.wind_sentence, *handbook_lines(curve)]
    told: list[Node] = [
        *map(Sentence, sentences),
        Figure("pitotbench.show.curves.curve_panels", (results, truth, limit), "main"),
    ]
    holds_for = [*lines, *part_lines(result), *location_lines(result), *assumption_lines(result)]
    rules = [judgment.sentence for judgment in judgments(result, limit)]
    flight = ", ".join(dict.fromkeys(f.flight for f in result.provenance.inputs if f.flight))
    return Heading(
        ": ".join(filter(None, (subject, flight))),
        (
            # What is not to be used says so before it says anything else.
            *([*told, *first] if result.usable else [*first, *told]),
            *([] if settings is None else [_settings(settings)]),
            Table(GLANCE_COLUMNS, glance_points(curve)),
            Download(
                f"card-{_plain(subject) or 'airspeed'}.csv",
                "Save the card as CSV",
                card_csv(curve, doubts),
            ),
            *map(Doubt, doubts[1:]),
            *map(Sentence, [*rules, *(f"{line[:1].upper()}{line[1:]}" for line in holds_for)]),
            *(Notice(each) for each in result.warnings if not is_doubt(each)),
            *_sources(result, flights or [result]),
            *_numbers(result),
            Heading(
                "Evidence",
                (
                    Figure("pitotbench.show.curves.parts_panels", (log, result)),
                    Figure("pitotbench.show.curves.bound_panels", (result, true)),
                    Figure("pitotbench.show.curves.residual_panels", (result,)),
                ),
                NUMBERS,
            ),
            *([Heading("The flight", (pictures,), NUMBERS)] if flown else []),
        ),
    )


def _settings(found: AutopilotSettings) -> Heading:
    lines = map(Sentence, settings_lines(found))
    return Heading(
        f"Parameters of {found.autopilot}", (Table(SETTING_COLUMNS, found.settings), *lines)
    )


def _sources(result: Calibration, flights: Sequence[Calibration]) -> list[Heading]:
    """What the answer rests on: the conditions of the flights and the checks."""
    winds = winds_of(flights)
    step = max(1, -(-len(winds) // _MOST_WINDS))
    thinned = [] if step == 1 else [f"Of {len(winds)} windows of the wind, one in {step} is shown"]
    model = f"model of the curve: {result.model}; samples: {result.samples:,}"
    conditions = conditions_of(result.provenance, [model, *thinned])
    return [
        Heading(
            "Conditions",
            (*map(Sentence, conditions), Table(WIND_COLUMNS, winds[::step])),
            SOURCES,
        ),
        Heading("Checks", (Table(CHECK_COLUMNS, flights_checks(flights)),), SOURCES),
    ]


def _numbers(result: Calibration) -> list[Heading]:
    """All that is known of the curve, the fit and what was weighed against it."""
    points = result.points
    parts: dict[str, list[Node]] = {
        "The curve in numbers": [Table(CURVE_COLUMNS, curve_points(result.curve))],
        "Fixed-speed methods in numbers": [Table(point_columns(result.curve), points)]
        if points
        else [],
        "The fit": [
            *map(Sentence, parameter_lines(result)),
            *([Sentence(departure_line(result))] if result.diagnostics.departures else []),
            *map(Sentence, wind_lines(result)),
            *map(Sentence, share_lines(result)),
            *map(Sentence, fit_lines(result)),
        ],
    }
    return [Heading(title, tuple(nodes), NUMBERS) for title, nodes in parts.items() if nodes]


def _plain(name: str) -> str:
    return "".join(letter if letter.isalnum() else "-" for letter in name)
