"""Show the aerodynamic terms of a model beside measured maneuvers: words, tables, JSON and a page."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.terms import (
    CHANNELS,
    MOTIONS,
    ChannelGap,
    ManeuverGap,
    OpenLoopFlight,
    TermEstimate,
    TermsAccount,
)
from pitotbench.show.columns import Column, html_table, json_rows, outside, print_table
from pitotbench.show.markup import render
from pitotbench.show.pages import page_version
from pitotbench.show.style import BLUE, INK, ORANGE, WIDE, Panel, stacked, svg
from pitotbench.units import DEGREE, FOOT, KNOT, POUND, STANDARD_GRAVITY

if TYPE_CHECKING:
    from rich.console import Console

POUND_FORCE = POUND * STANDARD_GRAVITY  # N
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
    told = f"model {first.model:.3g}, measured {first.measured.value:.3g} ± {first.measured.two_sigma:.2g}"
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
    Column("coefficient", lambda term: term.name, key="coefficient"),
    Column("unit", lambda term: term.unit, key="unit"),
    Column("model", lambda term: term.model, style=".4g", key="model"),
    Column("measured", lambda term: term.measured.value, style=".4g", key="measured"),
    Column("±2σ", lambda term: term.measured.two_sigma, style=".2g", key="two_sigma"),
    Column("change", lambda term: 100.0 * term.change.value, "%", "+.0f", key="change_percent"),
    Column(
        "±2σ of the change", lambda term: 100.0 * term.change.two_sigma, "%", ".0f", key="change_two_sigma_percent"
    ),
    Column("closes", lambda term: 100.0 * term.closes, "%", ".0f", key="closes_percent"),
    Column("not told from", lambda term: ", ".join(term.like), key="not_told_from", optional=True),
    Column("function of the file", lambda term: term.function, key="function"),
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


def print_terms(account: TermsAccount, console: "Console") -> None:
    """Print the answer, the terms and the gap of each channel on the maneuvers held out."""
    for text in sentences(account):
        console.print(outside(text))
    if account.terms:
        print_table(
            TERM_COLUMNS, account.terms, console, "Terms of the model's file, in the order of what they close"
        )
    print_table(GAP_COLUMNS, _gaps(account), console, "Deviation of the residual, in that of the noise")
    if account.silent:
        console.print(outside(f"The maneuvers say nothing of: {', '.join(account.silent)}."))


def terms_json(account: TermsAccount) -> dict[str, Any]:
    """Return the account as a JSON document."""
    return {
        "verdict": "differs" if account.terms else "no_gap",
        "aircraft": account.aircraft,
        "closure": account.closed,
        "terms": json_rows(TERM_COLUMNS, account.terms),
        "added_coefficients": dict(account.zeros),
        "channels": json_rows(GAP_COLUMNS, _gaps(account)),
        "maneuvers": [{"name": each.name, "held_out": each.held_out} for each in account.maneuvers],
        "silent": list(account.silent),
        "remarks": list(account.remarks),
    }


# The page: the gap over time in pounds and foot-pounds, and the maneuvers flown again with the measured controls.


def terms_page(account: TermsAccount, overlay: str, inputs: str) -> str:
    """Return the HTML of the account; `overlay` is its XML, empty where no term is off, `inputs` names the logs."""
    held = sorted(account.held_out, key=_size, reverse=True)[:SHOWN]
    names = {each.name for each in held}
    flown = [each for each in account.flown if each.name in names]
    return render(
        "terms.html",
        title=f"{account.aircraft} beside {inputs}",
        sentences=sentences(account),
        panels=[_gap_panel(each) for each in held] + [_flown_panel(each) for each in flown],
        terms=html_table(TERM_COLUMNS, account.terms) if account.terms else "",
        gaps=html_table(GAP_COLUMNS, _gaps(account)),
        maneuvers=[f"{each.name}{' (held out)' if each.held_out else ''}" for each in account.maneuvers],
        silent=", ".join(account.silent),
        overlay=overlay,
        version=page_version(),
    )


def _size(each: ManeuverGap) -> float:
    return sum(gap.before - gap.noise for gap in each.channels.values())


def _gap_panel(each: ManeuverGap) -> Panel:
    """The residual of the channels with a gap over time, of the model and of the corrected one."""
    significant = [name for name, gap in each.channels.items() if gap.significant] or list(each.channels)[:1]

    def drawn(name: str) -> Callable[[Axes], None]:
        place = CHANNELS.index(name)
        unit, factor = ("ft·lb", POUND_FORCE * FOOT) if "moment" in name else ("lb", POUND_FORCE)

        def draw(axes: Axes) -> None:
            axes.axhline(0.0, color=INK, lw=0.7)
            axes.plot(each.time, each.before[:, place] / factor, color=ORANGE, label="the model")
            axes.plot(each.time, each.after[:, place] / factor, color=BLUE, label="corrected")
            axes.set(ylabel=f"{name} [{unit}]")
            if name == significant[-1]:
                axes.set_xlabel("time [s]")

        return draw

    title = f"Measured less modeled: {each.name}{', held out' if each.held_out else ''}"
    return _stack([drawn(name) for name in significant], title)


def _flown_panel(each: OpenLoopFlight) -> Panel:
    """The measured motion, and those of the model and of the corrected one under the measured controls."""
    factors = (KNOT, DEGREE, DEGREE, DEGREE)

    def drawn(i: int) -> Callable[[Axes], None]:
        def draw(axes: Axes) -> None:
            lines = (
                (each.measured, INK, "measured"),
                (each.before, ORANGE, "the model"),
                (each.after, BLUE, "corrected"),
            )
            for values, color, label in lines:
                axes.plot(each.time, values[:, i] / factors[i], color=color, label=label)
            name, unit = MOTIONS[i]
            axes.set(ylabel=f"{name} [{unit}]")
            if i == len(MOTIONS) - 1:
                axes.set_xlabel("time [s]")

        return draw

    title = f"Flown with the measured controls: {each.name}{', held out' if each.held_out else ''}"
    return _stack([drawn(i) for i in range(len(MOTIONS))], title)


def _stack(draws: list[Callable[[Axes], None]], title: str) -> Panel:
    with stacked(draws, (WIDE[0], 0.9 + 1.15 * len(draws)), 3) as figure:
        return Panel(title, svg(figure, title))
