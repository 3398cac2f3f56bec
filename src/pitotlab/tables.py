"""Tables in Markdown. `python -m pitotlab tables` writes those of the documentation that repeat the code.

A new table is a function and a line of `TABLES`. What stands around a table is written by hand.
"""

import re
from argparse import ArgumentParser
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import fields
from pathlib import Path
from re import fullmatch
from typing import TYPE_CHECKING, Any

from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import Effect
from pitotbench.show.columns import Column, Row, shown_columns
from pitotbench.simulation.card import Card
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.units import from_si

if TYPE_CHECKING:
    from pandas import DataFrame

DOCS = Path(__file__).parents[2] / "docs"
Rows = Iterator[Sequence[str]]
Numbers = dict[str, float | list[float]]


def effect_rows(effects: Iterable[Effect] = EFFECTS.values()) -> Rows:
    """Yield a row for each parameter; the cells of the effect stand in its first row."""
    for effect in effects:
        form = f" (another form of `{effect.variant_of}`)" if effect.variant_of else ""
        first = [f"`{effect.name}`: {effect.what.rstrip('.')}{form}", effect.family, effect.acts_on]
        last = [str(effect.shows_in), effect.source]
        for p in effect.parameters:
            optional = " (optional)" if p.shape else ""
            cells = [f"`{p.name}`{optional}", f"{p.typical:g}", f"{p.low:g} to {p.high:g}", p.what]
            yield [*first, *cells, *last]
            first, last = [""] * len(first), [""] * len(last)


def card_numbers(card: Card) -> Numbers:
    """Return the numbers of a card as a case file writes them."""
    written: Numbers = {}
    for entry in fields(card):
        suffix, value = entry.metadata.get("suffix"), getattr(card, entry.name)
        each = value if isinstance(value, tuple) else (value,)
        numbers = [float(f"{from_si(v, suffix):.6g}") if suffix else v for v in each]
        name = f"{entry.name}_{suffix}" if suffix else entry.name
        written[name] = numbers if isinstance(value, tuple) else numbers[0]
    return written


def card_rows() -> Rows:
    """Yield a row for each maneuver: the numbers that other cards lack, or have otherwise."""
    common = card_numbers(Card())
    for name, maneuver in MANEUVERS.items():
        own = {key: value for key, value in card_numbers(maneuver.card).items() if common.get(key) != value}
        yield [f"`{name}`", ", ".join(f"`{key}` {_number(value)}" for key, value in own.items())]


def _number(value: float | list[float]) -> str:
    return f"[{', '.join(map(_number, value))}]" if isinstance(value, list) else f"{value:g}"


# Page and heading line of each table, and its rows.
TABLES: dict[tuple[str, str], Callable[[], Rows]] = {
    (
        "effects.md",
        "| effect | family | acts on | parameter | typical | range | what it is | best shown by | source |",
    ): effect_rows,
    ("case.md", "| maneuver | entries and defaults |"): card_rows,
}


def pages() -> dict[str, str]:
    """Return the text of each page with its tables as the code has them.

    Raises ValueError for a page that lacks the heading of a table.
    """
    texts: dict[str, str] = {}
    for (page, heading), rows in TABLES.items():
        text = texts.get(page) or (DOCS / page).read_text(encoding="utf-8")
        rule = "|" + "---|" * (heading.count("|") - 1)
        table = "".join(f"{line}\n" for line in (heading, rule, *("| " + " | ".join(row) + " |" for row in rows())))
        before, found, after = text.partition(heading + "\n")
        if not found:
            raise ValueError(f"docs/{page} has no table with the heading {heading!r}")
        texts[page] = before + table + re.sub(r"\A(\|.*\n)+", "", after)
    return texts


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Write the tables of the documentation that repeat the code: of effects, and of cards."""
    parser.parse_args(words)
    for page, text in pages().items():
        (DOCS / page).write_text(text, encoding="utf-8")


# Tables of any columns, and of a frame, in Markdown.


def markdown_table(columns: Sequence[Column[Row]], rows: Iterable[Row]) -> str:
    """A table as Markdown."""
    rows = list(rows)
    shown = shown_columns(columns, rows)
    cells = [[column.title for column in shown], *([column.text(row) for column in shown] for row in rows)]
    lines = ["| " + " | ".join(text.replace("|", r"\|") for text in line) + " |" for line in cells]
    return "\n".join([lines[0], "|" + "---|" * len(shown), *lines[1:]])


def frame_columns(table: "DataFrame", style: str = "") -> list[Column[dict[str, Any]]]:
    """A column each for those of a frame, for rows of `frame_rows`.

    A frame's column name is the heading; a unit in brackets at its end is the unit. Numbers with a fraction get the
    style; others and texts stay as they are.
    """

    def column(name: str) -> Column[dict[str, Any]]:
        parts = fullmatch(r"(.*) \[(.+)\]", name)
        heading, unit = parts.groups() if parts else (name, "")
        return Column(heading, lambda row: _styled(row[name], style), unit)

    return [column(str(name)) for name in table.columns]


def _styled(value: object, style: str) -> str:
    return format(value, style) if isinstance(value, float) else str(value)
