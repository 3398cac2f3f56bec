"""Show two versions of an airplane's file: what changed in flight, as words, tables, JSON, page."""

from collections.abc import Sequence
from typing import Any

from pitotbench.records.comparison import ChannelChange, FlownChange, ModelComparison, TermChange
from pitotbench.show.columns import Column, json_rows, with_minus_signs
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import (
    BLUE,
    GRAY,
    WIDE,
    Panel,
    broken,
    drawing,
    frame,
    level,
    line,
    named_rows,
    panel,
    written,
)
from pitotbench.show.tree import SOURCES, Figure, Heading, Node, Notice, Sentence, Table
from pitotbench.show.words import capital, listed, with_unit


def change_words(term: TermChange) -> str:
    """Return what changed in a term: `lift slope 3.9 → 4.8 per rad (+23 %)`."""
    if term.old is None and term.new is None:
        return term.name if term.name == term.part else f"{term.name} ({term.part})"
    values = [f"{value:.4g}" if value is not None else "none" for value in (term.old, term.new)]
    share = (
        ""
        if term.old in (None, 0.0) or term.new is None
        else f" ({_percent(term.new / term.old - 1.0)})"
    )
    unit = term.unit.lower().replace("ft2", "ft²").replace("m2", "m²")
    return f"{term.name} {values[0]} → {values[1]} {unit}".rstrip() + share


def comparison_sentences(found: ModelComparison) -> list[str]:
    """Return the answer: what changed in the file and in the forces, and how the airplane flies."""
    if not found.terms:
        return [
            f"{found.new} says the same as {found.old}: no number and no part of the airplane "
            "differs."
        ]
    if not found.channels:
        return [
            f"Nothing changed in flight along the card {_card(found)}; the files differ in what it "
            "does not use."
        ]
    acting = [change_words(term) for term in found.terms if term.effects]
    more = f"; and {len(acting) - _NAMED} other differences" * (len(acting) > _NAMED)
    return [
        f"{capital('; '.join(acting[:_NAMED]))}{more}: {_channel_words(found.channels)}.",
        *_flying_words(found.flown),
        *found.remarks,
    ]


_NAMED = 3  # differences of the files that one sentence can hold
_FELT = 0.003  # share by which a figure of steady flight has to change


def _card(found: ModelComparison) -> str:
    return f"{found.card.replace('_', ' ')}, as {found.old} flies it"


def _percent(share: float) -> str:
    digits = 2 if abs(share) < 1.0 else 3
    return with_minus_signs(f"{100.0 * share:+.{digits}g} %")


def _channel_words(channels: Sequence[ChannelChange]) -> str:
    """Channels that grew by one factor, then those that did not, the largest of each first."""
    alike: dict[str, list[str]] = {}
    for each in channels:
        if each.growth is not None:
            alike.setdefault(_percent(each.growth), []).append(each.channel)
    grown = [f"{listed(names)} {share}" for share, names in alike.items()]
    others = [each for each in channels if each.growth is None]
    most = [f"{each.channel} up to {100.0 * each.share:.2g} %" for each in others]
    said = [f"{listed(most)} of the largest in the flight"] if most else []
    return "; ".join([*grown, *said])


def _flying_words(flown: Sequence[FlownChange]) -> list[str]:
    """How the airplane flies: the figures of steady flight that changed."""
    if not flown:
        return []
    first = {each.name: each for each in reversed(flown) if each.name not in _LESSER}
    felt = [c for c in reversed(first.values()) if abs(c.new - c.old) > _FELT * abs(c.old)]
    if not felt:
        return ["It flies as before: stall, glide, climb and cruise are the same."]
    said = [
        f"{each.name} {each.old:,.3g} → {with_unit(f'{each.new:,.3g}', each.unit)} "
        f"({_percent(each.new / each.old - 1.0)})"
        for each in felt
    ]
    return [f"It flies: {'; '.join(said)}."]


# figures that follow from others
_LESSER = ("best lift-to-drag ratio", "speed of the best lift-to-drag ratio")


def _growth_percent(each: ChannelChange) -> float | None:
    return None if each.growth is None else 100.0 * each.growth


CHANGE_COLUMNS: tuple[Column[ChannelChange], ...] = (
    Column("channel", lambda each: each.channel, key="channel"),
    Column("phase", lambda each: each.phase or "the whole flight", key="phase"),
    Column("root mean square", lambda each: each.change, style=",.4g", key="change"),
    Column("largest", lambda each: each.largest, style=",.4g", key="largest"),
    Column("unit", lambda each: each.unit, key="unit"),
    Column("as coefficient", lambda each: each.coefficient, style=".4f", key="coefficient"),
    Column(
        "of the channel's largest", lambda each: 100.0 * each.share, "%", ".3g", key="share_percent"
    ),
    Column("throughout", _growth_percent, "%", "+.3g", "throughout_percent", optional=True),
)
FLOWN_COLUMNS: tuple[Column[FlownChange], ...] = (
    Column("figure", lambda each: each.name, key="name"),
    Column("condition", lambda each: each.condition, key="condition"),
    Column("old", lambda each: with_unit(f"{each.old:,.4g}", each.unit)),
    Column("new", lambda each: with_unit(f"{each.new:,.4g}", each.unit)),
    Column("change", lambda each: 100.0 * (each.new / each.old - 1.0), "%", "+.2f"),
    Column("", lambda each: each.unit or "1", key="unit"),
    Column("", lambda each: each.old, key="old"),
    Column("", lambda each: each.new, key="new"),
)
DIFFERENCE_COLUMNS: tuple[Column[TermChange], ...] = (
    Column("difference", change_words),
    Column("", lambda term: term.name, key="name"),
    Column("part of the file", lambda term: term.part, key="part"),
    Column("", lambda term: term.old, key="old"),
    Column("", lambda term: term.new, key="new"),
    Column("", lambda term: term.unit, key="unit"),
    Column("", lambda term: bool(term.effects), key="in_flight"),
    Column(
        "alone changes",
        lambda term: (
            ", ".join(f"{e.channel} {e.largest:,.3g} {e.unit}" for e in term.effects)
            or "nothing in flight"
        ),
    ),
    Column("", lambda term: json_rows(CHANGE_COLUMNS, term.effects), key="effects"),
)


def comparison_tree(found: ModelComparison) -> list[Node]:
    """Return what changed in flight.

    Sentences and the change of each channel; folded away are the differences of the files, the
    channels over time, and the phases of each.
    """
    picture = (Figure("pitotbench.show.comparison.change_panels", (found,), "single"),)
    traces = (Figure("pitotbench.show.comparison.trace_panels", (found,), "single"),)
    whole = f"Forces and moments along the card {_card(found)}"
    deep: list[tuple[str, tuple[Node, ...]]] = [
        (whole, (Table(CHANGE_COLUMNS, found.channels),)),
        ("Differences of the files", (Table(DIFFERENCE_COLUMNS, found.terms),)),
        ("Over the flight", traces if found.traces else ()),
        ("By phase of the flight", (Table(CHANGE_COLUMNS, found.located),)),
    ]
    return [
        *map(Sentence, comparison_sentences(found)),
        *(picture if found.channels else ()),
        Table(FLOWN_COLUMNS, found.flown, "Steady flight"),
        *(Heading(title, nodes, SOURCES) for title, nodes in deep if found.terms and nodes),
        Notice(
            "The old file flies the card once. Both files are then put into its states, with its "
            "surfaces and throttles, and their forces, moments, power and mass are read. Each "
            "difference is put alone into the old file, which gives its own part."
        ),
    ]


def comparison_json(found: ModelComparison) -> dict[str, Any]:
    """Return the comparison as a JSON document."""
    return {
        "old": found.old,
        "new": found.new,
        "card": found.card,
        "largest_share_percent": 100.0 * found.largest,
        "terms": json_rows(DIFFERENCE_COLUMNS, found.terms),
        "channels": json_rows(CHANGE_COLUMNS, found.channels),
        "located": json_rows(CHANGE_COLUMNS, found.located),
        "flown": json_rows(FLOWN_COLUMNS, found.flown),
        "remarks": list(found.remarks),
    }


def change_panels(found: ModelComparison, units: Units = BENCH) -> list[Panel]:
    """The change of each channel as a share of its largest value, the largest on top."""
    rows, channels = range(len(found.channels)), found.channels
    shares = [100.0 * (each.share if each.growth is None else each.growth) for each in channels]
    right = 1.6 * max(*shares, 0.0) or 1.0
    draw = drawing(
        lambda axes: axes.barh(
            rows, shares, height=0.6, color=[GRAY if c.growth is None else BLUE for c in channels]
        ),
        *(
            written(max(share, 0.0), row, _bar_words(each))
            for row, share, each in zip(rows, shares, channels, strict=True)
        ),
        named_rows([each.channel for each in channels]),
        frame("new less old [% of the channel]", "", xlim=(1.6 * min(*shares, 0.0), right)),
    )
    note = "In blue a channel that is larger or smaller by one factor; in gray the largest change."
    size = (WIDE[0], 0.9 + 0.3 * len(channels))
    return [panel("What changed in the same states", draw, note, size=size, units=units)]


def _bar_words(each: ChannelChange) -> str:
    if each.growth is not None:
        return f"{_percent(each.growth)} throughout"
    return f"up to {each.largest:,.3g} {each.unit}"


def trace_panels(found: ModelComparison, units: Units = BENCH) -> list[Panel]:
    """The change of each channel over time [s], the axes below one another."""
    title, time = "New less old, in the states that the old one flew", found.time - found.time[0]
    draws = [
        drawing(
            level(0.0),
            line(*broken(time, found.traces[c.channel])),
            frame("time [s]" if c is found.channels[-1] else "", f"{c.channel}\n[{c.unit}]"),
        )
        for c in found.channels
    ]
    return [panel(title, draws, size=(WIDE[0], 0.9 + 1.15 * len(draws)), units=units)]
