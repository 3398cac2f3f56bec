"""The voices of an answer: each walks its tree. Loads no drawing library until a picture is drawn."""

from collections.abc import Callable, Iterable, Sequence
from html import escape
from itertools import groupby
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from pitotbench.show.columns import html_table, outside, print_table, shown_columns
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.tree import (
    ANSWER,
    NUMBERS,
    Doubt,
    Download,
    Figure,
    Heading,
    Node,
    Notice,
    Sentence,
    Table,
    nodes_in,
)

if TYPE_CHECKING:
    from rich.console import Console


def print_tree(
    nodes: Iterable[Node], console: "Console", units: Units = BENCH, depth: int = ANSWER
) -> None:
    """Print an answer down to a depth: no pictures and no files. Above the depth of all numbers its
    notices are counted only.
    """
    read = [node for node in nodes_in([*nodes], depth) if not isinstance(node, Figure | Download)]
    for before, node in zip([None, *read], read, strict=False):
        if isinstance(node, Table):
            console.print()
            columns = units.columns(shown_columns(node.columns, node.rows))
            print_table(columns, node.rows, console, node.title)
            continue
        if isinstance(before, Table):
            console.print()
        if isinstance(node, Heading):
            console.print(outside(node.text, "bold"))
        elif isinstance(node, Sentence):
            console.print(outside(units.text(node.text)))
        elif isinstance(node, Doubt):
            words = node.text if node.first else f"warning: {node.text}"
            console.print(outside(units.text(words), "yellow"), soft_wrap=True)
        elif depth == NUMBERS:
            console.print(outside(f"note: {units.text(node.text)}"), soft_wrap=True)
    notices = sum(isinstance(node, Notice) for node in read)
    if notices and depth < NUMBERS:
        console.print(f"{notices} notes on what was read: -v prints them.")


def html_of(nodes: Iterable[Node], units: Units = BENCH, depth: int = NUMBERS) -> str:
    """An answer as HTML down to a depth. What lies deeper than the answer is folded away, and so are
    notices.
    """
    parts = []
    for kind, group in groupby(nodes, lambda node: (type(node), getattr(node, "first", False))):
        parts.append(_HTML[kind[0]]([*group], units, depth))
    return "\n".join(filter(None, parts))


def _headings(nodes: Sequence[Heading], units: Units, depth: int) -> str:
    parts = []
    for node in nodes:
        inner = html_of(node.nodes, units, depth)
        if node.depth == ANSWER:
            parts.append(f'<div class="part"><h3>{escape(node.text)}</h3>\n{inner}</div>')
        elif node.depth <= depth:
            summary = f"<summary>{escape(node.text)}</summary>"
            parts.append(f"<details>{summary}{inner}</details>")
    return "\n".join(parts)


def _sentences(nodes: Sequence[Sentence], units: Units, _: int) -> str:
    return "\n".join(f"<p>{escape(units.text(node.text))}</p>" for node in nodes)


def _doubts(nodes: Sequence[Doubt], units: Units, _: int) -> str:
    if nodes[0].first:
        told = " ".join(units.text(node.text) for node in nodes)
        return f'<p class="doubt">{escape(told)}</p>'
    return f'<ul class="warn">{_items(nodes, units)}</ul>'


def _notices(nodes: Sequence[Notice], units: Units, _: int) -> str:
    summary = f"What was read: {len(nodes)} note{'s' if len(nodes) > 1 else ''}"
    return f"<details><summary>{summary}</summary><ul>{_items(nodes, units)}</ul></details>"


def _items(nodes: Sequence[Doubt] | Sequence[Notice], units: Units) -> str:
    return "".join(f"<li>{escape(units.text(node.text))}</li>" for node in nodes)


def _tables(nodes: Sequence[Table], units: Units, _: int) -> str:
    parts = []
    for node in nodes:
        title = f"<h4>{escape(node.title)}</h4>" if node.title else ""
        columns = units.columns(shown_columns(node.columns, node.rows))
        parts.append(f'<div class="table">{title}{html_table(columns, node.rows)}</div>')
    return "\n".join(parts)


def _figures(nodes: Sequence[Figure], units: Units, _: int) -> str:
    return "\n".join(_figure(node, units) for node in nodes)


def _figure(node: Figure, units: Units) -> str:
    drawn = "\n".join(
        f"<figure><figcaption>{escape(each.title)}</figcaption>{each.drawing}"
        + (f'<p class="note">{escape(units.text(each.note))}</p>' if each.note else "")
        + "</figure>"
        for each in node.panels(units)
    )
    return f'<div class="{"main" if node.main else "panels wide"}">{drawn}</div>'


def _downloads(nodes: Sequence[Download], *_: object) -> str:
    links = " ".join(
        f'<a download="{escape(node.name)}" href="data:text/csv;charset=utf-8,{quote(node.text)}">'
        f"{escape(node.words)}</a>"
        for node in nodes
    )
    return f'<p class="save">{links}</p>'


_HTML: dict[type, Callable[[Any, Units, int], str]] = {
    Heading: _headings,
    Sentence: _sentences,
    Doubt: _doubts,
    Notice: _notices,
    Table: _tables,
    Figure: _figures,
    Download: _downloads,
}
