"""An answer as a tree: its parts in the order in which they are read, made once for all voices.

One function a kind of answer makes the tree from the answer's record, and the renderers walk it:
the terminal, a page, a record, a notebook. A renderer leaves out nodes by their kind or depth,
never by what they say; a doubt is in all of them. Loads no drawing library.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from pitotbench.show.columns import Column

# Depths of a tree.
ANSWER = 0  # what is found
SOURCES = 1  # what it rests on
NUMBERS = 2  # all that is known


@dataclass(frozen=True, slots=True)
class Heading:
    """A part with its title, its nodes, and how deep a reader goes to find it."""

    text: str
    nodes: "tuple[Node, ...]"
    depth: int = ANSWER


@dataclass(frozen=True, slots=True)
class Sentence:
    """What the answer says. Numbers in it are in the units of the bench: kt, ft, °C, inHg."""

    text: str


@dataclass(frozen=True, slots=True)
class Doubt:
    """What the answer must not go without. The `first` says what to do about it, too."""

    text: str
    first: bool = False


@dataclass(frozen=True, slots=True)
class Notice:
    """How something was read, which changes no number."""

    text: str


@dataclass(frozen=True, slots=True)
class Code:
    """Lines of a file or of a terminal, to be taken word for word."""

    text: str


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of one kind and their columns."""

    columns: Sequence[Column[Any]]
    rows: Sequence[Any]
    title: str = ""


@dataclass(frozen=True, slots=True)
class Figure:
    """Pictures, drawn only by a renderer that shows them.

    `drawn_by` is the name of the function that draws them, and `arguments` are its own before the
    reader's units. `layout`: `main` for the answer's, `wide`, `narrow`, `whole` for those that fill
    the page, or `single` for one that shrinks with it.
    """

    drawn_by: str
    arguments: tuple[Any, ...]
    layout: str = "wide"


@dataclass(frozen=True, slots=True)
class Download:
    """A file to take along: its name, the words of its link, and its text."""

    name: str
    words: str
    text: str


Node = Heading | Sentence | Doubt | Notice | Code | Table | Figure | Download


def down_to(nodes: Iterable[Node], depth: int) -> Iterator[Node]:
    """Yield the nodes that a reader finds down to a depth: of a deeper part its doubts alone."""
    for node in nodes:
        if getattr(node, "depth", depth) <= depth:
            yield node
        else:
            yield from (each for each in nodes_in([node]) if isinstance(each, Doubt))


def nodes_in(nodes: Iterable[Node], depth: int = NUMBERS) -> Iterator[Node]:
    """Yield every node down to a depth, a part before what is in it."""
    for node in down_to(nodes, depth):
        yield node
        yield from nodes_in(getattr(node, "nodes", ()), depth)
