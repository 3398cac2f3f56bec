"""Show the aerodynamic terms of a model beside measured maneuvers: words, tables, JSON and a page."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.aircraft import ChannelChange, ModelComparison, TermChange
from pitotbench.records.terms import (
    CHANNELS,
    MOTIONS,
    SIGNIFICANT,
    ChannelGap,
    ManeuverGap,
    OpenLoopFlight,
    TermEstimate,
    TermsAccount,
)
from pitotbench.show.columns import Column, json_rows
from pitotbench.show.style import BLUE, INK, ORANGE, WIDE, Panel, broken, stacked, svg
from pitotbench.show.tree import (
    SOURCES,
    Figure,
    Heading,
    Node,
    Notice,
    Sentence,
    Table,
)
from pitotbench.units import DEGREE, FOOT, KNOT, POUND_FORCE, Array

SHOWN = 3  # maneuvers with pictures: those with the largest gap before
_NO_TERM = "none of its terms is off by more than its bound"

# The answer in sentences, its tables, and the same as JSON.


def sentences(account: TermsAccount) -> list[str]:
    """Return the answer: how many terms differ, the first of them, and what they close."""
    count = len(account.terms)
    if not count:
        return [f"{account.aircraft}: {_NO_TERM}.", *account.remarks]
    first = account.terms[0]
    many = "one term" if count == 1 else f"{count} terms"
    told = (
        f"model {first.model:.3g}, measured {first.measured.value:.3g} ± "
        f"{first.measured.two_sigma:.2g}"
    )
    told = f"{told} {first.unit}".rstrip() + f" ({100.0 * first.change.value:+.0f} %)"
    lead = f"{account.aircraft} differs in {many}; the first is the {first.name}: {told}."
    held = [each for each in account.maneuvers if each.held_out]
    on = (
        f"{len(held)} maneuver{'s' * (len(held) > 1)} held out"
        if held
        else "the maneuvers themselves; none was held out"
    )
    return [
        lead,
        f"They close {100.0 * account.closed:.0f} % of the explainable gap, judged on {on}.",
        *account.remarks,
    ]


TERM_COLUMNS: tuple[Column[TermEstimate], ...] = (
    Column("coefficient", lambda term: term.name),
    Column("unit", lambda term: term.unit),
    Column("model", lambda term: term.model, style=".4g"),
    Column("measured", lambda term: term.measured.value, style=".4g"),
    Column("±2σ", lambda term: term.measured.two_sigma, style=".2g"),
    Column("change", lambda term: 100.0 * term.change.value, "%", "+.0f"),
    Column(
        "±2σ of the change",
        lambda term: 100.0 * term.change.two_sigma,
        "%",
        ".0f",
    ),
    Column("closes", lambda term: 100.0 * term.closes, "%", ".0f"),
    Column("not told from", lambda term: ", ".join(term.like), optional=True),
    Column("function of the file", lambda term: term.function),
)

_Gap = tuple[str, ChannelGap]
GAP_COLUMNS: tuple[Column[_Gap], ...] = (
    Column("channel", lambda row: row[0], key="channel"),
    Column("before", lambda row: np.sqrt(row[1].before), "σ", ".2f", key="before_sigma"),
    Column("after", lambda row: np.sqrt(row[1].after), "σ", ".2f", key="after_sigma"),
    Column("no term explains", lambda row: np.sqrt(row[1].noise), "σ", ".2f", key="noise_sigma"),
    Column("a gap before", lambda row: row[1].significant, key="significant"),
    Column(
        "closed",
        lambda row: 100.0 * row[1].closed if row[1].significant else None,
        "%",
        ".0f",
        key="closed_percent",
    ),
)


def _gaps(account: TermsAccount) -> list[_Gap]:
    return [(name, account.gap_of(name)) for name in account.channels]


def terms_tree(account: TermsAccount, overlay: str = "") -> list[Node]:
    """The answer, the terms and the gap of each channel on the maneuvers held out; `overlay` is the
    XML of the correction, empty where no term is off.
    """
    flown = [f"{each.name}{' (held out)' if each.held_out else ''}" for each in account.maneuvers]
    return [
        *map(Sentence, sentences(account)),
        Figure(lambda _: _terms_panels(account)),
        Table(TERM_COLUMNS, account.terms, "Terms of the model's file, by what they close"),
        Table(GAP_COLUMNS, _gaps(account), "Deviation of the residual, in that of the noise"),
        *(
            Sentence(f"The maneuvers say nothing of: {', '.join(account.silent)}.")
            for _ in account.silent[:1]
        ),
        *([Heading("The correction as a patch", (Sentence(overlay),), SOURCES)] if overlay else []),
        Heading("How it was found", (*map(Sentence, [_FOUND, *flown]),), SOURCES),
    ]


_FOUND = (
    "Equation error: the measured force and moment coefficients less those of the model in the "
    "measured state, as a sum of the file's own functions (Klein and Morelli 2006, ch. 5). A term "
    "is told where its size is significant and where it closes some of the gap that it was not fitted "
    "to. Maneuvers:"
)


def terms_json(account: TermsAccount) -> dict[str, Any]:
    """Return the account as a JSON document: a gap for each term, as that of an effect."""
    gaps, fitted = _gaps(account), account.fitted
    sums = {name: sum(getattr(gap, name) for _, gap in gaps) for name in ("before", "after")}
    return {
        "schema": 1,
        "verdict": "named" if account.terms else "no_gap",
        "aircraft": account.aircraft,
        "gaps": [_term_json(term) for term in account.terms],
        "free": [],
        "remains": any(gap.after > SIGNIFICANT * gap.noise for _, gap in gaps),
        "gap_before": sums["before"],
        "gap_after": sums["after"],
        "closure": fitted.closed if account.terms else None,
        "closure_holdout": account.closed if account.terms and fitted is not account else None,
        "patch": [
            {"name": term.function, "parameters": {"change": term.change.value}}
            for term in account.terms
        ],
        "added_coefficients": dict(account.zeros),
        "channels": json_rows(GAP_COLUMNS, _gaps(account)),
        "maneuvers": [{"name": each.name, "held_out": each.held_out} for each in account.maneuvers],
        "silent": list(account.silent),
        "remarks": list(account.remarks),
    }


def _term_json(term: TermEstimate) -> dict[str, Any]:
    """A term as a gap. A regression on terms alone has no rivals elsewhere, so no probability."""
    part = "drag" if term.channel == "drag" else "lift, stability and damping"
    size = {
        "name": "change",
        "value": term.change.value,
        "two_sigma": term.change.two_sigma,
        "unit": term.unit,
        "model": term.model,
        "measured": term.measured.value,
        "measured_two_sigma": term.measured.two_sigma,
    }
    cause = {"name": term.name, "acts_on": "file", "probability": None, "parameters": [size]}
    return {
        "part": part,
        "probability": None,
        "named": not term.like,
        "causes": [cause | {"function": term.function, "not_told_from": list(term.like)}],
        "closes": term.closes,
        "closes_held_out": term.closes,
    }


# The page: the gap over time in pounds and foot-pounds, and the maneuvers flown again with the
# measured controls.


def _terms_panels(account: TermsAccount) -> list[Panel]:
    def size(each: ManeuverGap) -> float:
        return sum(gap.before - gap.noise for gap in each.channels.values())

    held = sorted(account.held_out, key=size, reverse=True)[:SHOWN]
    names = {each.name for each in held}
    flown = [each for each in account.flown if each.name in names]
    return [_gap_panel(each) for each in held] + [_flown_panel(each) for each in flown]


def _gap_panel(each: ManeuverGap) -> Panel:
    """The residual of the channels with a gap over time, of the model and of the corrected one."""
    significant = [name for name, gap in each.channels.items() if gap.significant] or list(
        each.channels
    )[:1]
    rows = []
    for name in significant:
        unit, factor = ("ft·lb", POUND_FORCE * FOOT) if "moment" in name else ("lb", POUND_FORCE)
        before, after = (
            values[:, CHANNELS.index(name)] / factor for values in (each.before, each.after)
        )
        rows.append(
            (f"{name} [{unit}]", [(before, ORANGE, "the model"), (after, BLUE, "corrected")])
        )
    title = f"Measured less modeled: {each.name}{', held out' if each.held_out else ''}"
    return _stack(title, each.time, rows, zero=True)


def _flown_panel(each: OpenLoopFlight) -> Panel:
    """The measured motion, and those of the model and of the corrected one under the measured
    controls.
    """
    sides = (
        (each.measured, INK, "measured"),
        (each.before, ORANGE, "the model"),
        (each.after, BLUE, "corrected"),
    )
    rows = []
    for i, ((name, unit), factor) in enumerate(
        zip(MOTIONS, (KNOT, DEGREE, DEGREE, DEGREE), strict=True)
    ):
        rows.append(
            (
                f"{name} [{unit}]",
                [(values[:, i] / factor, color, label) for values, color, label in sides],
            )
        )
    title = f"Flown with the measured controls: {each.name}{', held out' if each.held_out else ''}"
    return _stack(title, each.time, rows)


_Line = tuple[Array, str, str]  # values over time, color, and the entry of the legend


def _stack(
    title: str, time: Array, rows: Sequence[tuple[str, Sequence[_Line]]], zero: bool = False
) -> Panel:
    """Axes below one another over time [s]: the label and the lines of each, and a line at zero
    where asked for.
    """

    def drawn(label: str, lines: Sequence[_Line], last: bool) -> Callable[[Axes], None]:
        def draw(axes: Axes) -> None:
            if zero:
                axes.axhline(0.0, color=INK, lw=0.7)
            for values, color, name in lines:
                axes.plot(*broken(time, values), color=color, label=name or None)
            axes.set(ylabel=label, **({"xlabel": "time [s]"} if last else {}))

        return draw

    draws = [drawn(label, lines, label == rows[-1][0]) for label, lines in rows]
    with stacked(draws, (WIDE[0], 0.9 + 1.15 * len(draws)), 3) as figure:
        return Panel(title, svg(figure, title))


# Two versions of an airplane's file: what changed in flight, in words, tables, JSON and a page.


def change_words(term: TermChange) -> str:
    """Return what changed in a term: `lift slope 3.9 → 4.8 per rad (+23 %)`."""
    if term.old is None and term.new is None:
        return term.name if term.name == term.part else f"{term.name} ({term.part})"
    told = [f"{value:.4g}" if value is not None else "none" for value in (term.old, term.new)]
    share = (
        ""
        if term.old in (None, 0.0) or term.new is None
        else f" ({100.0 * (term.new / term.old - 1.0):+.3g} %)"
    )
    return f"{term.name} {told[0]} → {told[1]} {term.unit}".rstrip() + share


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
        Figure(lambda _: [_change_panel(found)] if found.traces else []),
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


def _change_panel(found: ModelComparison) -> Panel:
    rows = [
        (f"{c.channel} [{c.unit}]", [(found.traces[c.channel], BLUE, "")]) for c in found.channels
    ]
    title = "New less old, in the states that the old one flew"
    return _stack(title, found.time - found.time[0], rows, zero=True)
