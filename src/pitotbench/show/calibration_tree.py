"""The tree of a calibration: what it found, what to doubt, what it rests on. One for all voices."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from pitotbench.records.calibration import AutopilotSettings, Calibration
from pitotbench.records.log import FlightLog
from pitotbench.show.calibration import (
    NamedFlight,
    doubts_of,
    flight_lines,
    is_doubt,
    short_answer_of,
)
from pitotbench.show.columns import Column
from pitotbench.show.curve_rows import (
    CURVE_COLUMNS,
    GLANCE_COLUMNS,
    POINT_COLUMNS,
    card_csv,
    curve_points,
    glance_points,
    off_curve,
    prior_sentences,
)
from pitotbench.show.deliverables import SETTING_COLUMNS, settings_lines
from pitotbench.show.handbook import handbook_advice, handbook_sentence
from pitotbench.show.limits import AUTO, Limit, judgments
from pitotbench.show.record import (
    CHECK_COLUMNS,
    WIND_COLUMNS,
    conditions_of,
    flights_checks,
    wind_two_sigma,
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
from pitotbench.show.words import capital, with_unit
from pitotbench.timeline import minutes_text
from pitotbench.units import KNOT, MetersPerSecond, percent_text

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
    shown: list[Node] = [
        *([Sentence(answer.correction_sentence)] if result.usable else []),
        Sentence(answer.wind_sentence),
        *(Sentence(handbook_sentence(curve, each)) for each in curve.published),
        *(
            Sentence(text)
            for text in dict.fromkeys(handbook_advice(result, each) for each in curve.published)
            if text
        ),
        Figure("pitotbench.show.curves.curve_panels", (results, truth, limit), "main"),
    ]
    rules = [judgment.sentence for judgment in judgments(result, limit)]
    flight = ", ".join(dict.fromkeys(f.flight for f in result.provenance.inputs if f.flight))
    return Heading(
        ": ".join(filter(None, (subject, flight))),
        (
            # What is not to be used says so before anything else, and not what to add.
            *([*shown, *first] if result.usable else [*first, *shown]),
            *([] if settings is None else [_settings(settings)]),
            Table(GLANCE_COLUMNS, glance_points(curve)),
            Download(
                f"card-{_plain(subject) or 'airspeed'}.csv",
                "Save the card as CSV",
                card_csv(result),
            ),
            *map(Doubt, doubts[1:]),
            *map(
                Sentence,
                [
                    *rules,
                    *map(capital, [*lines, *_conditions(result)]),
                ],
            ),
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


def flight_tree(found: NamedFlight, limit: Limit | str | None = AUTO) -> Heading:
    """The tree of a calibrated flight of a log, without its pictures over time."""
    flight, result = found.flight, found.flight.calibration
    subject = f"{found.name} ({'simulated' if flight.log.simulated else 'measured'})"
    results, lines = {result.model: result}, flight_lines(flight)
    return calibration_tree(subject, results, limit, lines=lines, settings=found.settings)


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


_MOST_PARTS = 6  # of the log that are named
_LOCATIONS = {
    "static": "the static source",
    "total": "the total source",
    "impact": "the impact pressure",
}


def _conditions(result: Calibration) -> Iterator[str]:
    """Return what the answer holds for: parts of the log [min], place of the error, assumptions.

    The place decides what the error does to the altitude.
    """
    if result.left_out:
        start, more = result.log_start, len(result.parts) - _MOST_PARTS
        shown = [
            f"{minutes_text(begin - start)} to {minutes_text(end - start)}"
            for begin, end in result.parts[:_MOST_PARTS]
        ]
        yield (
            f"used: {', '.join(shown)}{f' and {more} more parts' if more > 0 else ''} (minutes of "
            f"the log); left out: {', '.join(result.left_out)}"
        )
    unseen = ", assumed (without a height by GPS the log does not show it)" * result.place_assumed
    yield f"place of the error: {_LOCATIONS[result.error_location]}{unseen}"
    if (day := result.day) is not None:
        yield (
            f"the air is {round(day.departure):+d} K from the standard day; a probe 5 K off would "
            f"move the curve by ±{day.by_five_kelvin / KNOT:.1f} kt, one that is so at the slowest "
            f"airspeed alone by up to {day.by_slow_end / KNOT:.1f} kt"
        )
    yield from [*_assumptions(result), *prior_sentences(result.priors)]


_ASSUMED = {
    "temperature_k": ("temperature", "K"),
    "recovery_factor": ("recovery factor", ""),
    "static_pressure_pa": ("static pressure", "Pa"),
    "impact_pressure_zero_pa": ("zero of the impact pressure", "Pa"),
    "velocity_mps": ("GPS velocity", "m/s"),
    "total_source": ("total source", "of q_c"),
    "wind_kt": ("wind", "kt"),
    "latency_s": ("GPS latency", "s"),
}
_STATED_BY = {"header": "stated by the log"}  # any other in its own word


def _assumptions(result: Calibration) -> Iterator[str]:
    """The accuracies on which the bounds depend, and the zero offset that is corrected."""
    shown = [(*_ASSUMED[a.name], a, _STATED_BY.get(a.source, a.source)) for a in result.assumptions]
    held = [
        f"{name} ±{with_unit(f'{a.two_sigma:.3g}', unit)} ({source})"
        for name, unit, a, source in shown
        if a.two_sigma > 0.0
    ]
    exact = [(name, source) for name, _, a, source in shown if not a.two_sigma > 0.0]
    if held:
        yield f"The ± holds constant errors of the sensors (2σ): {'; '.join(held)}."
        # Through q_c: as its root by the density, and as the speed itself by the velocity.
        middle = float(np.mean(result.curve.indicated_airspeed_kt[[0, -1]]))
        yield (
            f"No log shows a factor: 1 % on the GPS velocity moves the curve by {0.01 * middle:.1f} "
            f"kt at {middle:.0f} KIAS, 1 % on the static pressure by {0.005 * middle:.1f} kt."
        )
    if exact:
        names, sources = (", ".join(dict.fromkeys(each)) for each in zip(*exact, strict=True))
        yield f"The ± holds no constant error of {names} ({sources})."
    zero = result.impact_pressure_zero
    if zero is not None:
        seen = "as read at rest" if result.zero_at_rest else "a constant part of Δp looks the same"
        yield (
            f"The correction includes a sensor zero of {zero.value:+.0f} ± {zero.two_sigma:.0f} Pa "
            f"(2σ; {seen}), Δp/q_c does not."
        )


def _numbers(result: Calibration) -> list[Heading]:
    """All that is known of the curve, the fit and what was weighed against it."""
    points = [
        *POINT_COLUMNS,
        Column("point − curve", partial(off_curve, result.curve), "kt", "+.2f"),
    ]
    parts: dict[str, Sequence[Node]] = {
        "The curve in numbers": [Table(CURVE_COLUMNS, curve_points(result.curve))],
        "Fixed-speed methods in numbers": [Table(points, result.points)] if result.points else [],
        "The fit": [*map(Sentence, _fit(result))],
    }
    return [Heading(title, tuple(nodes), NUMBERS) for title, nodes in parts.items() if nodes]


def _fit(result: Calibration) -> Iterator[str]:
    """Return what was fitted with its bounds: parameters, wind, residual and state of the fit.

    What widens the bounds is there as well.
    """
    values = ", ".join(f"{p.name} = {p.value:+.5f} ± {p.two_sigma:.5f}" for p in result.parameters)
    yield f"parameters (± is 2σ): {values}; x = q_ci / {result.reference_pressure:.2f} Pa"
    if sizes := result.diagnostics.departures:
        yield (
            "departure of the curve from level, slope and a part in 1/q_ci, rms in Δp/q_c, with its "
            f"probability: {', '.join(f'{size} with {percent_text(p)}' for size, p in sizes.items())}"
        )
    if (wind := result.wind) is None:
        yield "wind velocity: unknown"
    else:
        parts = [
            f"{to} {v.value / KNOT:+.2f} ± {v.two_sigma / KNOT:.2f} kt"
            for to, v in (("north", wind.north), ("east", wind.east), ("down", wind.down))
            if v is not None
        ]
        yield f"wind velocity (± is 2σ): toward {', '.join(parts)}"
        yield from _shares(result, wind_two_sigma(wind))
    yield (
        f"2σ of the residual {result.residual_two_sigma / KNOT:.2f} kt, {result.samples:,} "
        f"samples, condition number {result.condition_number:.1e}; {result.reason}"
    )


_LEAST_SHARE = 0.005  # kt, below which a share would be printed as zero


def _shares(result: Calibration, wind_kt: float) -> Iterator[str]:
    """How much each stated accuracy widens the bounds, the largest contribution first."""
    total = float(np.sqrt(np.mean(result.curve.two_sigma_kt**2)))
    for share in sorted(result.shares, key=lambda share: -share.curve - share.wind):
        found = share.estimate
        # The digits of a value that is negligible against its bound come from rounding alone.
        value = found.value if abs(found.value) > 1e-6 * found.two_sigma else 0.0
        if max(share.curve, share.wind) > _LEAST_SHARE * KNOT:
            yield (
                f"{share.name} (estimated {value:+.3g} ± {found.two_sigma:.3g}) contributes "
                f"±{share.curve / KNOT:.2f} kt to the curve's ±{total:.2f} kt and "
                f"±{share.wind / KNOT:.2f} kt to the wind's ±{wind_kt:.2f} kt (2σ, as squares; "
                "parts overlap)"
            )


def _plain(name: str) -> str:
    return "".join(letter if letter.isalnum() else "-" for letter in name)
