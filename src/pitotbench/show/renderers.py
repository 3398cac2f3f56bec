"""The voices of an answer: each walks its tree. Loads no drawing library before it draws."""

from collections.abc import Callable, Iterable, Sequence
from html import escape
from itertools import groupby
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from pitotbench.show.columns import Column, Row, html_table, outside, print_table, shown_columns
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.tree import (
    ANSWER,
    NUMBERS,
    Code,
    Doubt,
    Download,
    Figure,
    Heading,
    Node,
    Notice,
    Sentence,
    Table,
    down_to,
    nodes_in,
)

if TYPE_CHECKING:
    from rich.console import Console

_SAID = {  # by kind: what stands before a text on a terminal, and its style
    Heading: ("", "bold"),
    Sentence: ("", ""),
    Doubt: ("warning: ", "yellow"),
    Notice: ("note: ", ""),
}


def print_tree(
    nodes: Iterable[Node], console: "Console", units: Units = BENCH, depth: int = ANSWER
) -> None:
    """Print an answer down to a depth: no pictures and no files.

    Above all that it rests on, its notices are counted only.
    """
    said = [n for n in nodes_in(nodes, depth) if not isinstance(n, Figure | Code | Download)]
    read = [n for n in said if depth > ANSWER or not isinstance(n, Notice)]
    for before, node in zip([None, *read], read, strict=False):
        if isinstance(node, Table) or isinstance(before, Table):
            console.print()
        if isinstance(node, Table):
            columns = units.columns(shown_columns(node.columns, node.rows))
            print_table(columns, node.rows, console, units.text(node.title))
        else:
            words, style = _SAID[type(node)]
            text = node.text if getattr(node, "first", False) else words + node.text
            console.print(outside(units.text(text), style), soft_wrap=True)
    if len(said) > len(read):
        console.print(f"Notes on what was read: {len(said) - len(read)}; -v prints them.")


def plain_table(
    columns: Sequence[Column[Row]], rows: Sequence[Row], units: Units = BENCH
) -> dict[str, Any]:
    """A table as texts: headings with their units, which columns hold numbers, rows of cells."""
    shown = units.columns(shown_columns(columns, rows))
    return {
        "head": [column.title for column in shown],
        "numbers": [bool(column.style) for column in shown],
        "rows": [[column.text(row) for column in shown] for row in rows],
    }


def plain_of(
    nodes: Iterable[Node], units: Units = BENCH, depth: int = NUMBERS
) -> list[dict[str, Any]]:
    """Return an answer as texts by the kinds of its nodes down to a depth, for the page.

    The page draws the pictures and gives the files itself: of these the place alone is printed.
    """
    return [
        {"kind": type(node).__name__.lower(), "first": getattr(node, "first", False)}
        | {
            "deep": getattr(node, "depth", ANSWER) > ANSWER,
            "main": getattr(node, "layout", "") == "main",
        }
        | {"text": units.text(getattr(node, "text", "") or getattr(node, "title", ""))}
        | {"nodes": plain_of(getattr(node, "nodes", ()), units, depth)}
        | (plain_table(node.columns, node.rows, units) if isinstance(node, Table) else {})
        for node in down_to(nodes, depth)
        if not isinstance(node, Download)
    ]


def html_of(nodes: Iterable[Node], units: Units = BENCH, depth: int = NUMBERS) -> str:
    """An answer as HTML down to a depth, with notices and what lies deeper folded away."""
    groups = groupby(
        down_to(nodes, depth),
        lambda node: (type(node), getattr(node, "first", False), getattr(node, "layout", "")),
    )
    return "\n".join(_HTML[kind]([*group], units, depth) for (kind, *_), group in groups)


def _heading(node: Heading, units: Units, depth: int) -> str:
    inner, title = html_of(node.nodes, units, depth), escape(units.text(node.text))
    if node.depth == ANSWER:
        return f'<div class="part"><h3>{title}</h3>\n{inner}</div>'
    return f"<details><summary>{title}</summary>{inner}</details>"


def _texts(tag: str, nodes: Iterable[Any], units: Units) -> str:
    return "\n".join(f"<{tag}>{escape(units.text(node.text))}</{tag}>" for node in nodes)


def _table(node: Table, units: Units) -> str:
    title = f"<h4>{escape(units.text(node.title))}</h4>" * bool(node.title)
    columns = units.columns(shown_columns(node.columns, node.rows))
    return f'<div class="table">{title}{html_table(columns, node.rows)}</div>'


def _figures(nodes: Sequence[Figure], units: Units) -> str:
    """Pictures beside one another, in the layout of the first."""
    panels = (p for n in nodes for p in resolve_name(n.drawn_by)(*n.arguments, units))
    drawn = (
        f"<figure><figcaption>{escape(each.title)}</figcaption>{each.drawing}"
        + (f'<p class="note">{escape(units.text(each.note))}</p>' if each.note else "")
        + "</figure>"
        for each in panels
    )
    layout = nodes[0].layout
    kind = layout if layout == "main" else f"panels {layout}"
    return f'<div class="{kind}">{"".join(drawn)}</div>'


# By kind, what some nodes of one kind that follow one another look like on a page.
_HTML: dict[type, Callable[[Any, Units, int], str]] = {
    Heading: lambda nodes, units, depth: "\n".join(_heading(n, units, depth) for n in nodes),
    Sentence: lambda nodes, units, _: _texts("p", nodes, units),
    Doubt: lambda nodes, units, _: (
        f'<div class="doubt">{_texts("p", nodes, units)}</div>'
        if nodes[0].first
        else f'<ul class="warn">{_texts("li", nodes, units)}</ul>'
    ),
    Notice: lambda nodes, units, _: (
        "<details><summary>Notes on what was read: "
        f"{len(nodes)}</summary><ul>{_texts('li', nodes, units)}</ul></details>"
    ),
    Code: lambda nodes, *_: "\n".join(f"<pre>{escape(node.text)}</pre>" for node in nodes),
    Table: lambda nodes, units, _: "\n".join(_table(node, units) for node in nodes),
    Figure: lambda nodes, units, _: _figures(nodes, units),
    Download: lambda nodes, *_: "\n".join(
        f'<p class="save"><a download="{escape(node.name)}" '
        f'href="data:text/csv;charset=utf-8,{quote(node.text)}">{escape(node.words)}</a></p>'
        for node in nodes
    ),
}
