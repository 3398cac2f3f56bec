"""Show two versions of an airplane's file: what changed in flight, in words, tables, JSON, a page."""

from collections.abc import Sequence
from typing import Any

from pitotbench.records.comparison import ChannelChange, ModelComparison, TermChange
from pitotbench.show.columns import Column, json_rows
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import WIDE, Panel, broken, drawing, frame, level, line, panel
from pitotbench.show.tree import Figure, Heading, Node, Notice, Sentence, Table


def change_words(term: TermChange) -> str:
    """Return what changed in a term: `lift slope 3.9 → 4.8 per rad (+23 %)`."""
    if term.old is None and term.new is None:
        return term.name if term.name == term.part else f"{term.name} ({term.part})"
    values = [f"{value:.4g}" if value is not None else "none" for value in (term.old, term.new)]
    share = (
        ""
        if term.old in (None, 0.0) or term.new is None
        else f" ({100.0 * (term.new / term.old - 1.0):+.3g} %)"
    )
    return f"{term.name} {values[0]} → {values[1]} {term.unit}".rstrip() + share


def comparison_sentences(found: ModelComparison) -> list[str]:
    """Return the answer: which channels changed, by how much and where, and by which terms."""
    if not found.terms:
        return [
            f"{found.new} says the same as {found.old}: no number and no part of the airplane "
            "differs."
        ]
    acting = [term for term in found.terms if term.effects]
    card = f"along the card {found.card.replace('_', ' ')}, as {found.old} flies it"
    if not found.channels:
        return [f"Nothing changed in flight {card}; the files differ in what it does not use."]
    first = found.channels[0]
    place = max(
        (each for each in found.located if each.channel == first.channel),
        key=lambda each: each.largest,
    )
    return [
        f"{len(found.channels)} channel{'s' * (len(found.channels) > 1)} changed {card}; most of "
        "all the "
        f"{first.channel}, by up to {first.largest:,.4g} {first.unit} ({100.0 * first.share:,.3g} "
        "% of its largest "
        f"value) in the phase {place.phase}.",
        f"By: {'; '.join(change_words(term) for term in acting)}.",
        *found.remarks,
    ]


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
    """What changed in flight: sentences, the channels over time, terms, and the phases of each."""
    tables: list[tuple[str, Sequence[Column[Any]], Sequence[Any]]] = [
        ("Differences of the files", DIFFERENCE_COLUMNS, found.terms),
        ("Changes over the whole flight", CHANGE_COLUMNS, found.channels),
        ("Changes by phase", CHANGE_COLUMNS, found.located if found.channels else ()),
    ]
    return [
        *map(Sentence, comparison_sentences(found)),
        *([Figure("pitotbench.show.comparison.change_panels", (found,))] if found.traces else []),
        *(Heading(title, (Table(columns, rows),)) for title, columns, rows in tables if rows),
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
        "remarks": list(found.remarks),
    }


def change_panels(found: ModelComparison, units: Units = BENCH) -> list[Panel]:
    """The change of each channel over time [s], the axes below one another."""
    title, time = "New less old, in the states that the old one flew", found.time - found.time[0]

    draws = [
        drawing(
            level(0.0),
            line(*broken(time, found.traces[c.channel])),
            frame("time [s]" if c is found.channels[-1] else "", f"{c.channel} [{c.unit}]"),
        )
        for c in found.channels
    ]
    return [panel(title, draws, size=(WIDE[0], 0.9 + 1.15 * len(draws)), units=units)]
