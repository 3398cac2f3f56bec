"""Templates to HTML, and the finished parts of a page. Loads no drawing library."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import groupby

from jinja2 import Environment, PackageLoader, StrictUndefined

from pitotbench.show.calibration import ShortAnswer
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.renderers import html_of
from pitotbench.show.tree import NUMBERS, Heading, Node, Table
from pitotbench.show.words import heading, words
from pitotbench.version import __version__


def render(template: str, **content: object) -> str:
    """The HTML of a template of this package."""
    return environment().get_template(template).render(**content)


def page_of(
    title: str,
    nodes: Iterable[Node],
    units: Units = BENCH,
    subtitle: str = "",
    sections: "Iterable[Section]" = (),
    after: Iterable[Node] = (),
) -> str:
    """Return an answer as one self-contained page (HTML) in the reader's units.

    Finished sections stand behind it, and nodes `after` them.
    """
    drawn = [section for section in sections if section.html]
    return render(
        "tree.html",
        title=title,
        subtitle=subtitle,
        version=__version__,
        groups=[(name, [*group]) for name, group in groupby(drawn, key=lambda each: each.group)],
        body=html_of(map(_folded, nodes), units),
        drawn=drawn,
        after=html_of(after, units),
    )


_SHORT = 12  # rows of a table that stands open on a page


def _folded(node: Node) -> Node:
    """A node as it is, or a long table folded away below its title."""
    if not isinstance(node, Table) or len(node.rows) <= _SHORT:
        return node
    title = f"{len(node.rows)} rows: {node.title}" if node.title else f"{len(node.rows)} rows"
    return Heading(title, (Table(node.columns, node.rows),), NUMBERS)


def environment() -> Environment:
    """The templates of this package; their filters `words` and `heading` turn names into words."""
    found = Environment(
        loader=PackageLoader("pitotbench.show"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    found.filters |= {"heading": heading, "words": words}
    return found


@dataclass(frozen=True, slots=True)
class Section:
    """A part of a page: its anchor, group and title in the index, its short answer and its HTML."""

    anchor: str
    group: str
    title: str
    answer: ShortAnswer
    html: str
