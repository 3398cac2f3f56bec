"""Tables in Markdown. `python -m pitotlab tables` writes those of the documentation that repeat the
code.

A new table is a function and a line of `TABLES`. What stands around a table is written by hand.
"""

import csv
import re
from argparse import ArgumentParser
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from functools import partial
from importlib import import_module
from pathlib import Path
from re import fullmatch
from statistics import mode
from typing import TYPE_CHECKING, Any

import pitotbench
from pitotbench.calibration.options import PRIORS, Priors
from pitotbench.cli.app import COMMANDS
from pitotbench.effects import EFFECTS, FAMILIES
from pitotbench.effects import effect as effect_records
from pitotbench.effects.effect import Effect, Excitation, Parameter
from pitotbench.show.columns import Column, Row, shown_columns
from pitotbench.simulation.card import Card
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.units import from_si
from pitotlab.made import RESULTS, read_made
from pitotlab.study.rules import RULES

if TYPE_CHECKING:
    from pandas import DataFrame

DOCS = Path(__file__).parents[2] / "docs"
FIGURES = DOCS / "how-good-is-it.md"  # holds the measured numbers
PAPER = DOCS / "paper.md"  # holds some of them
Rows = Iterator[Sequence[str]]
Numbers = dict[str, float | list[float]]


def effect_rows(effects: Sequence[Effect]) -> Rows:
    """Yield a row for each effect of a family: what it is, its parameters, what shows it, and its
    source.

    The row tells where the effect acts only if most of the family act elsewhere.
    """
    sources = short_sources(EFFECTS.values())
    shown_by = {excitation: name for name, excitation in excitations()}
    usual = mode(effect.acts_on for effect in effects)
    for effect in effects:
        place = f" (on the {effect.acts_on})" if effect.acts_on != usual else ""
        form = f" (another form of `{effect.variant_of}`)" if effect.variant_of else ""
        what = f"`{effect.name}`{place}: {effect.what.rstrip('.')}{form}"
        parameters = "<br>".join(map(_parameter, effect.parameters))
        shows = shown_by.get(effect.shows_in, str(effect.shows_in))
        yield [what, parameters, shows, sources[effect.name]]


def _parameter(p: Parameter) -> str:
    optional = ", optional" if p.shape else ""
    grows = f", in proportion to the {p.grows_with}" if p.grows_with else ""
    return f"`{p.name}` {p.typical:g} ({p.low:g}…{p.high:g}{optional}): {p.what}{grows}"


def short_sources(effects: Iterable[Effect]) -> dict[str, str]:
    """Return the source of each effect by its name: of one that has stood above, author and year
    alone.

    A source without a year is cut at its first colon.
    """
    told: dict[str, str] = {}
    for effect in effects:
        source = effect.source
        short = re.match(r"[^:;]*?\b(19|20)\d\d\b", source) or re.match("[^:]*", source)
        told[effect.name] = short[0] if short and source in told.values() else source
    return told


def excitations() -> Iterator[tuple[str, Excitation]]:
    """Yield the ways of flying that show several effects, each with its name."""
    for name, value in vars(effect_records).items():
        if isinstance(value, Excitation):
            yield name.replace("_", " ").lower(), value


def excitation_rows() -> Rows:
    """Yield a row for each way of flying that shows several effects."""
    for name, excitation in excitations():
        yield [name, excitation.text, ", ".join(f"`{each}`" for each in excitation.maneuvers)]


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
        numbers = card_numbers(maneuver.card)
        own = {key: value for key, value in numbers.items() if common.get(key) != value}
        yield [f"`{name}`", ", ".join(f"`{key}` {_number(value)}" for key, value in own.items())]


def _number(value: float | list[float]) -> str:
    return f"[{', '.join(map(_number, value))}]" if isinstance(value, list) else f"{value:g}"


def prior_rows() -> Rows:
    """Yield a row for each number of the calibration's priors."""
    for each in fields(Priors):
        (low, high), told = each.metadata["usual"], each.metadata
        value = getattr(PRIORS, each.name)
        yield [f"`{each.name}`", f"{value:g}", told["unit"], f"{low:g}…{high:g}", told["source"]]


def command_rows() -> Rows:
    """Yield a row for each command: its arguments, and its flags by all their names."""
    for command in COMMANDS:
        flags = import_module(command.module).FLAGS
        names = [each.names for each in flags]
        given = [f"`{each[0]}`" for each in names if not each[0].startswith("-")]
        told = [" ".join(f"`{n}`" for n in each) for each in names if each[0].startswith("-")]
        yield [f"`{command.name}`", ", ".join(given), ", ".join(told)]


def python_rows() -> Rows:
    """Yield the public names of Python, the records, the errors and the functions apart."""
    names = sorted(pitotbench.__all__, key=str.lower)
    errors = [each for each in names if each.endswith("Error")]
    records = [each for each in names if each[0].isupper() and each not in errors]
    others = [each for each in names if each not in (*errors, *records)]
    for kind, some in (("records", records), ("errors", errors), ("functions", others)):
        yield [kind, ", ".join(f"`{each}`" for each in some)]


def claim_rows() -> Rows:
    """Yield a row for each claim of the paper: its words, what is measured, and the bands."""
    for rule in RULES.values():
        yield [
            rule.number,
            f"{rule.words} ({rule.where})",
            rule.quantity,
            rule.reproduced,
            rule.in_part or "–",
        ]


def verdict_rows() -> Rows:
    """Yield a row for each claim as flown: its verdict and our numbers."""
    with (RESULTS / "claims.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            yield [row["claim"], row["verdict"], row["ours"]]


def made_rows() -> Rows:
    """Yield a row for each table of results: what it stands behind, and how it was made."""
    for made in read_made():
        command = f"`python -m pitotlab {made.command}`"
        yield [made.table, made.rows, made.build, made.date, made.seeds, command]


# Page and heading line of each table, and its rows.
TABLES: dict[tuple[str, str], Callable[[], Rows]] = {
    ("effects.md", "| best shown by | what to fly | maneuvers |"): excitation_rows,
    **{
        ("effects.md", f"| {family} effect | parameters | best shown by | source |"): partial(
            effect_rows, effects
        )
        for family, effects in FAMILIES.items()
    },
    ("case.md", "| maneuver | entries and defaults |"): card_rows,
    ("contract.md", "| command | arguments | flags |"): command_rows,
    ("contract.md", "| what | names |"): python_rows,
    ("claims.md", "| claim | the paper | measured | reproduced | in part |"): claim_rows,
    ("claims.md", "| claim | verdict | ours |"): verdict_rows,
    ("how-good-is-it.md", "| table | rows | build | date | seeds | command |"): made_rows,
    ("method.md", "| prior | usual value | unit | usual range | why |"): prior_rows,
}


def pages() -> dict[str, str]:
    """Return the text of each page with its tables as the code has them.

    Raises ValueError for a page that lacks the heading of a table.
    """
    texts: dict[str, str] = {}
    for (page, heading), rows in TABLES.items():
        text = texts.get(page) or (DOCS / page).read_text(encoding="utf-8")
        rule = "|" + "---|" * (heading.count("|") - 1)
        lines = (heading, rule, *(f"| {' | '.join(row)} |" for row in rows()))
        table = "\n".join(lines) + "\n"
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


def write_figures(figures: Mapping[str, str], page: Path = FIGURES) -> None:
    """Write measured numbers into a page, each between `<!-- its name -->` and `<!-- / -->`.

    Raises ValueError for a name that the page lacks.
    """
    text = page.read_text(encoding="utf-8")
    for name, number in figures.items():
        before, mark, rest = text.partition(f"<!-- {name} -->")
        _, end, after = rest.partition("<!-- / -->")
        if not end:
            raise ValueError(f"{page} has no place for the number {name!r}")
        text = before + mark + number + end + after
    page.write_text(text, encoding="utf-8")


def markdown_table(columns: Sequence[Column[Row]], rows: Iterable[Row]) -> str:
    """A table as Markdown."""
    rows = list(rows)
    shown = shown_columns(columns, rows)
    cells = [
        [column.title for column in shown],
        *([column.text(row) for column in shown] for row in rows),
    ]
    lines = ["| " + " | ".join(text.replace("|", r"\|") for text in line) + " |" for line in cells]
    return "\n".join([lines[0], "|" + "---|" * len(shown), *lines[1:]])


def frame_columns(table: "DataFrame", style: str = "") -> list[Column[dict[str, Any]]]:
    """A column each for those of a frame, for rows of `frame_rows`.

    A frame's column name is the heading; a unit in brackets at its end is the unit. Numbers with a
    fraction get the style; others and texts stay as they are.
    """

    def column(name: str) -> Column[dict[str, Any]]:
        parts = fullmatch(r"(.*) \[(.+)\]", name)
        heading, unit = parts.groups() if parts else (name, "")
        return Column(heading, lambda row: _styled(row[name], style), unit)

    return [column(str(name)) for name in table.columns]


def _styled(value: object, style: str) -> str:
    return format(value, style) if isinstance(value, float) else str(value)
