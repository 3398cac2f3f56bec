"""An answer in all its voices, held against its document: which written numbers the document does
not hold, which doubts a voice lacks, and what stays in the units of the bench.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from html import unescape
from io import StringIO
from math import isfinite
from typing import Any

import numpy as np
from rich.console import Console

from pitotbench.show.reader_units import BENCH, QUOTED, Units, units_named
from pitotbench.show.renderers import html_of, plain_of, print_tree
from pitotbench.show.tree import (
    ANSWER,
    NUMBERS,
    SOURCES,
    Code,
    Doubt,
    Download,
    Figure,
    Heading,
    Node,
    Table,
    nodes_in,
)

METRIC = units_named("km/h,m,degf,hpa")
_FACTORS = {BENCH: (1.0, 100.0), METRIC: (1.0, 100.0, 1.852, 0.3048, 1.8, 33.8639)}
_DECIMAL = re.compile(r"(?<![\w.:,])[+\-−±]?\d[\d,]*\.\d+(?![\w.:]|e[+\-])")
BENCH_UNIT = re.compile(r"\d (kt|KIAS|KCAS|KTAS|ft|inHg|°C)(?![\w/²])")


def as_text(html: str) -> str:
    """A page as a reader sees it: a line a row, a cell apart from the next."""
    lines = re.sub(r"</t[dh]>", " ", re.sub(r"</(tr|p|li|h\d)>", "\n", html))
    return unescape(re.sub(r"<pre>.*?</pre>|<svg.*?</svg>|<[^>]*>", "", lines, flags=re.DOTALL))


def without_pictures(nodes: Iterable[Node]) -> tuple[Node, ...]:
    """An answer without what no text is compared of: pictures, and files word for word."""
    kept = (n for n in nodes if not isinstance(n, Figure | Code))
    return tuple(
        Heading(n.text, without_pictures(n.nodes), n.depth) if isinstance(n, Heading) else n
        for n in kept
    )


def _flat(told: Sequence[dict[str, Any]]) -> str:
    lines = []
    for node in told:
        rows = [" ".join(cells) for cells in node.get("rows", ())]
        lines += [node["text"], *rows, _flat(node["nodes"])]
    return "\n".join(lines)


def voices_of(nodes: Iterable[Node], units: Units) -> dict[str, str]:
    """The texts of the terminal, the terminal with -v, a page, a record, a notebook and the panel of
    the page in the browser.
    """
    found = without_pictures(nodes)

    def printed(depth: int) -> str:
        stream = StringIO()
        print_tree(found, Console(file=stream, width=400), units, depth)
        return stream.getvalue()

    return {
        "terminal": printed(ANSWER),
        "terminal -v": printed(NUMBERS),
        "page": as_text(html_of(found, units)),
        "record": as_text(html_of(found, units, SOURCES)),
        "notebook": as_text(html_of(found, units, ANSWER)),
        "panel": _flat(plain_of(found, units, SOURCES)),
    }


def numbers_in(document: Any) -> Iterator[float]:
    """Every number of a document, those in its texts too."""
    if isinstance(document, bool):
        return
    if isinstance(document, int | float):
        yield float(document)
    elif isinstance(document, str):
        for each in re.findall(r"\d[\d,]*\.?\d*", document):
            yield float(each.replace(",", "").rstrip("."))
    elif isinstance(document, dict | list | tuple):
        for each in [*document, *document.values()] if isinstance(document, dict) else document:
            yield from numbers_in(each)


def unknown_numbers(text: str, document: Any, units: Units = BENCH) -> list[str]:
    """The written decimals that no number of a document rounds to, in one of the units."""
    known = np.array([abs(each) for each in numbers_in(document) if isfinite(each)])
    unknown = []
    for written in dict.fromkeys(_DECIMAL.findall(text)):
        plain = written.lstrip("+-−±").replace(",", "")
        value, ulp = float(plain), 10.0 ** -len(plain.partition(".")[2])
        near = (
            np.abs(factor * known - value).min(initial=np.inf)
            <= 0.5 * (1.0 + (factor if units != BENCH else 0.0)) * ulp + 1e-9
            for factor in _FACTORS[units]
        )
        if not any(near):
            unknown.append(written)
    return unknown


def contradictions(
    nodes: Iterable[Node], document: Any, beside: Sequence[float] = ()
) -> dict[str, list[str]]:
    """What each voice says that the document does not, by voice and unit; and the doubts that one
    lacks. `beside`: numbers that a sentence explains and no answer holds.
    """
    nodes = tuple(nodes)
    found: dict[str, list[str]] = {}
    for units in (BENCH, METRIC):
        doubts = [n.text for n in nodes_in(nodes) if isinstance(n, Doubt)]
        for name, text in voices_of(nodes, units).items():
            wrong = unknown_numbers(text, [document, *beside], units)
            plain = " ".join(text.split())
            wrong += [
                f"no doubt: {each}"
                for each in doubts
                if " ".join(units.text(each).split()) not in plain
            ]
            if wrong:
                found[f"{name}, {units.speed}"] = wrong
    return found


def left_in_knots(nodes: Iterable[Node]) -> list[str]:
    """The lines that some voice writes in the units of the bench for a reader of others. Quoted
    rules are by right in their own.
    """
    voices = voices_of(_without_quotes(nodes), METRIC).values()
    lines = (line for text in voices for line in text.splitlines())
    return sorted({line for line in lines if BENCH_UNIT.search(line)})


def _without_quotes(nodes: Iterable[Node]) -> tuple[Node, ...]:
    texts = ((n, {"text": re.sub(rf"\S+{QUOTED}\w+", "", getattr(n, "text", ""))}) for n in nodes)
    return tuple(
        n
        if isinstance(n, Table | Figure | Code | Download)
        else replace(
            n, **text, **({"nodes": _without_quotes(n.nodes)} if isinstance(n, Heading) else {})
        )
        for n, text in texts
    )
