"""The account of a log and the check of an aircraft: for the terminal and as plain data."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pitotbench.logbook.identity import airplane_of, day_of
from pitotbench.records.aircraft import AircraftCheck, Attached, ManeuverCheck, StepResponse
from pitotbench.records.log import ChannelSummary, FlightLog, FlightSummary, LogInspection, Question
from pitotbench.records.performance import Performance, PerformanceFigure
from pitotbench.show.calibration import is_doubt
from pitotbench.show.columns import Column, json_rows
from pitotbench.show.tree import Doubt, Figure, Heading, Node, Notice, Sentence, Table
from pitotbench.show.words import with_unit, words
from pitotbench.timeline import minutes_text
from pitotbench.units import DEGREE, FOOT, KNOT, POUND, SYMBOLS, from_si

# The units in which a person reads a channel of a canonical one.
_FIELD = {
    "pa": "inhg", "k": "degc", "mps": "kt", "m": "ft", "rad": "deg", "radps": "degps", "mps2": "g", "kg": "lb",
    "kgps": "pph",
}  # fmt: skip


def _unit(channel: ChannelSummary) -> str:
    return (
        "rpm"
        if channel.name.startswith("propeller_speed")
        else _FIELD.get(channel.unit, channel.unit)
    )


def _reading(channel: ChannelSummary, value: float | None) -> str | None:
    """A value with the unit of the field, without the digits that nobody reads."""
    if value is None:
        return None
    number = f"{float(from_si(value, _unit(channel))) if channel.unit else value:.5g}"
    return with_unit(f"{float(number):,.10g}", SYMBOLS.get(_unit(channel), ""))


CHANNEL_COLUMNS: tuple[Column[ChannelSummary], ...] = (
    Column("channel", lambda c: words(c.name)),
    Column("", lambda c: c.name, key="name"),
    Column("", lambda c: c.unit or "-", key="unit"),
    Column("", lambda c: c.low, key="low"),
    Column("", lambda c: c.high, key="high"),
    Column("5 %", lambda c: _reading(c, c.low), "", "s"),
    Column("95 %", lambda c: _reading(c, c.high), "", "s"),
    Column("changes", lambda c: c.rate, "1/s", ".3g", "rate_hz"),
)
QUESTION_COLUMNS: tuple[Column[Question], ...] = (
    Column("question", lambda q: q.name, key="question"),
    Column("answered", lambda q: q.answered, key="answered"),
    Column("what is missing", lambda q: q.words, key="missing"),
)


SUMMARY_COLUMNS: tuple[Column[FlightSummary], ...] = (
    Column("file", lambda f: f.file, key="file"),
    Column("begins", lambda f: f.start or None, key="start"),
    Column("airplane", lambda f: f.airplane or None, key="airplane"),
    Column("minutes", lambda f: None if f.refusal else f.seconds / 60.0, "", ".0f", "minutes"),
    Column(
        "KIAS from", lambda f: None if f.refusal else f.airspeeds[0] / KNOT, "", ".0f", "low_kt"
    ),
    Column("to", lambda f: None if f.refusal else f.airspeeds[1] / KNOT, "", ".0f", "high_kt"),
    Column("", lambda f: f.refusal or None, key="refusal"),
)


def summaries_tree(flights: Sequence[FlightSummary]) -> list[Node]:
    """The flights of a folder, and below them the files that were not read."""
    return [
        Table(SUMMARY_COLUMNS, [each for each in flights if not each.refusal]),
        *(Sentence(str(each)) for each in flights if each.refusal),
    ]


def summaries_json(flights: Sequence[FlightSummary]) -> list[dict[str, Any]]:
    """The flights of a folder as plain data, a row each."""
    return json_rows(SUMMARY_COLUMNS, flights)


def inspection_sentences(found: LogInspection) -> list[str]:
    """The account in sentences: extent, speeds, headings, and the bound to expect."""
    minutes = sum(end - start for start, end in found.flights) / 60.0
    low, _, high = (value / KNOT for value in found.airspeeds)
    bottom, _, top = (value / FOOT for value in found.heights)
    count = len(found.flights)
    sentences = [
        f"{found.rows:,} rows at {found.rate:.3g} Hz: {count} flight{'s' if count > 1 else ''}, "
        f"{minutes:.1f} min, {len(found.pauses)} pause{'' if len(found.pauses) == 1 else 's'}.",
        f"Indicated airspeeds {low:.0f} to {high:.0f} kt, pressure altitudes {bottom:,.0f} to "
        f"{top:,.0f} ft, tracks in {found.headings} of 12 sectors of 30°.",
        f"Wind about {np.hypot(*found.wind) / KNOT:.0f} kt from "
        f"{np.arctan2(-found.wind[1], -found.wind[0]) / DEGREE % 360.0:03.0f}°"
        + (" on the whole; a calibration finds one for each part." if found.wind_drifts else "."),
    ]
    if found.expected is None:
        return [*sentences, f"No error curve can be found: {found.refusal}."]
    speeds, bound = found.expected
    points = ", ".join(
        f"{bound[i] / KNOT:.2f} kt at {speeds[i] / KNOT:.0f} KIAS"
        for i in dict.fromkeys((0, len(speeds) // 2, -1))
    )
    if len(speeds) == 1:
        points = f"{bound[0] / KNOT:.2f} kt at {speeds[0] / KNOT:.0f} KIAS"
    heights = any(q.answered for q in found.questions if q.name.startswith("altitude"))
    given = f"model {found.model}, noise known{', without what the height adds' if heights else ''}"
    return [
        *sentences,
        f"In light turbulence, expect an error curve with 2σ of at least {points} ({given}).",
    ]


def inspection_tree(found: LogInspection, log: FlightLog | None = None) -> list[Node]:
    """Return the account of a log: sentences, warnings, pictures, questions, channels, pauses."""
    known = [] if log is None else filter(None, (airplane_of(log), day_of(log)))
    flight = ", ".join(known)
    return [
        *([Sentence(f"{flight}.")] if flight else []),
        *map(Sentence, inspection_sentences(found)),
        *(Doubt(each) if is_doubt(each) else Notice(each) for each in found.warnings),
        *(
            [Figure("pitotbench.show.inspection_panels.inspection_panels", (log, found))]
            if log
            else []
        ),
        Heading("What can be learned", (Table(QUESTION_COLUMNS, found.questions),)),
        Heading(
            "Channels: what nine tenths of the rows lie between",
            (
                Table(CHANNEL_COLUMNS, found.channels),
                *(
                    Sentence(f"pause of {length:.0f} s after {minutes_text(start)}")
                    for start, length in found.pauses
                ),
            ),
        ),
    ]


def inspection_json(found: LogInspection) -> dict[str, Any]:
    """The account as plain data, in knots, feet, degrees and seconds."""
    expected = [] if found.expected is None else zip(*found.expected, strict=True)
    return {
        "rows": found.rows,
        "rate_hz": found.rate,
        "channels": json_rows(CHANNEL_COLUMNS, found.channels),
        "flights": [{"start_s": start, "end_s": end} for start, end in found.flights],
        "pauses": [{"start_s": start, "length_s": length} for start, length in found.pauses],
        "track_sectors": found.headings,
        "indicated_airspeed_kt": [value / KNOT for value in found.airspeeds],
        "pressure_altitude_ft": [value / FOOT for value in found.heights],
        "wind_speed_kt": float(np.hypot(*found.wind)) / KNOT,
        "wind_from_deg": float(np.arctan2(-found.wind[1], -found.wind[0]) / DEGREE) % 360.0,
        "wind_drifts": found.wind_drifts,
        "questions": json_rows(QUESTION_COLUMNS, found.questions),
        "expected": [
            {"indicated_airspeed_kt": v / KNOT, "two_sigma_kt": b / KNOT} for v, b in expected
        ],
        "refusal": found.refusal or None,
        "warnings": list(found.warnings),
    }


MANEUVER_COLUMNS: tuple[Column[ManeuverCheck], ...] = (
    Column("maneuver", lambda m: m.maneuver, key="maneuver"),
    Column("speeds", lambda m: " ".join(f"{v:.0f}" for v in m.speeds_kt), "KCAS", key="speeds_kt"),
    Column("flown", lambda m: not m.failure, key="flown"),
    Column("time", lambda m: m.minutes, "min", ".1f", "minutes"),
    Column("on condition", lambda m: m.on_condition, "%", ".0%", "on_condition"),
)
STEP_COLUMNS: tuple[Column[StepResponse], ...] = (
    Column(
        "step", lambda s: f"{words(s.quantity)} {with_unit(f'{s.step:+.0f}', s.unit)}", key="step"
    ),
    Column("at", lambda s: s.speed_kt, "KCAS", ".0f", "speed_kt"),
    Column("overshoot", lambda s: s.overshoot, "%", ".0%", "overshoot"),
    Column("settled to 10 %", lambda s: s.settled, "s", ".1f", "settled_s"),
)


def check_sentences(check: AircraftCheck) -> list[str]:
    """Return an aircraft's check: whether it flies, its engines, speeds, channels it lacks."""
    flown = [m for m in check.maneuvers if not m.failure]
    answer = f"{check.aircraft}: {len(flown)} of {len(check.maneuvers)} maneuvers can be flown."
    failures = [f"{m.maneuver} was not flown: {m.failure}" for m in check.maneuvers if m.failure]
    if check.set_to_zero:
        failures.append(
            "Set to 0, since only FlightGear writes them (or a name is misspelled): "
            f"{', '.join(check.set_to_zero)}."
        )
    if check.attached is None:
        return [
            answer,
            "It has an autopilot of its own and flies the cards as they are written.",
            *failures,
        ]
    return [answer, *_found(check.attached), *failures]


def _found(found: Attached) -> list[str]:
    fastest = (
        "Mach 0.7, to which the bench keeps, is"
        if found.mach_limited
        else "the maximum level speed is"
    )
    count = {1: "one engine", 2: "two engines"}.get(found.engines, f"{found.engines} engines")
    sentences = [
        f"{found.mass_kg / POUND:,.0f} lb, {count} ({found.engine_kind}), thrust lag "
        f"{found.engine_time_s:.1f} s.",
        f"At {found.altitude_ft:,.0f} ft with flaps up the stall speed is {found.stall_kt:.0f} "
        f"KCAS, and {fastest} {found.fastest_kt:.0f} KCAS: both found by flying the model.",
    ]
    if found.missing:
        sentences.append(
            "Not recorded, because the model has no such channel: "
            f"{', '.join(map(words, found.missing))}."
        )
    return [*sentences, *(f"Warning: {each}." for each in found.warnings)]


def check_tree(check: AircraftCheck) -> list[Node]:
    """The check of an aircraft: sentences, maneuvers, trim and step responses."""
    return [
        *map(Sentence, check_sentences(check)),
        Heading(
            "In light turbulence; on condition is the share of samples within the tolerances",
            (Table(MANEUVER_COLUMNS, check.maneuvers),),
        ),
        Figure("pitotbench.show.pages.aircraft_panels", (check,)),
        Heading("Steps of the autopilot, in smooth air", (Table(STEP_COLUMNS, check.steps),)),
    ]


def _rounded(found: PerformanceFigure, value: float | None, sign: str = "") -> str | None:
    """A value of a figure with its unit."""
    if value is None:
        return None
    digits = 0 if abs(value) >= _WHOLE and not sign else 1
    return with_unit(f"{value:{sign},.{digits}f}", found.unit)


_WHOLE = 300.0  # in the figure's unit, from which on no decimal is read
PERFORMANCE_COLUMNS: tuple[Column[PerformanceFigure], ...] = (
    Column("figure", lambda f: f.name, key="name"),
    Column("condition", lambda f: f.condition, key="condition"),
    Column("model", lambda f: _rounded(f, f.model), "", "s"),
    Column("handbook", lambda f: _rounded(f, f.published), "", "s", optional=True),
    Column("difference", lambda f: _rounded(f, f.difference, "+"), "", "s", optional=True),
    Column("", lambda f: f.unit or "1", key="unit"),
    Column("", lambda f: f.model, key="model"),
    Column("", lambda f: f.published, key="published"),
    Column("", lambda f: f.difference, key="difference"),
)
SKIPPED_COLUMNS: tuple[Column[tuple[str, str]], ...] = (
    Column("left out", lambda s: s[0], key="name"),
    Column("reason", lambda s: s[1], key="reason"),
)


def performance_sentence(found: Performance) -> str:
    """The performance in a sentence: stall, climb, cruise and glide, as far as they were found."""
    first: dict[str, PerformanceFigure] = {}
    for each in found.figures:
        # Of cruise the fastest at the lowest height, of all else the first condition.
        if each.name not in first or (each.name == "cruise speed" and "2,000 ft" in each.condition):
            first[each.name] = each
    said = [
        said.format(_rounded(first[name], first[name].model))
        for name, said in _SAID.items()
        if name in first
    ]
    return (
        f"{found.aircraft} at {found.mass / POUND:,.0f} lb, the loading of its file: "
        f"{', '.join(said) or 'no steady flight was found'}."
    )


_SAID = {  # by figure, its words in the sentence
    "stall speed": "it stalls at {}",
    "best rate of climb": "climbs {} at sea level",
    "service ceiling": "reaches {}",
    "cruise speed": "flies level at {}",
    "glide ratio": "glides {} to 1",
}


def performance_tree(found: Performance) -> list[Node]:
    """Return the tree of the performance of an aircraft, beside its handbook if there is one.

    What was left out is listed.
    """
    picture = Figure("pitotbench.show.inspection_panels.performance_panels", (found,))
    tables = (
        Table(PERFORMANCE_COLUMNS, found.figures, "every figure"),
        Table(SKIPPED_COLUMNS, found.skipped, "not found"),
    )
    return [
        Sentence(performance_sentence(found)),
        *([picture] if found.figures else []),
        *tables,
    ]


def performance_json(found: Performance) -> dict[str, Any]:
    """The performance as plain data; each figure in its unit."""
    return {
        "aircraft": found.aircraft,
        "weight_lb": found.mass / POUND,
        "figures": json_rows(PERFORMANCE_COLUMNS, found.figures),
        "skipped": json_rows(SKIPPED_COLUMNS, found.skipped),
    }
