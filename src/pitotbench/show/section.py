"""A finished part of a page. Loads no drawing library: campaigns carry sections between processes."""

from dataclasses import dataclass

from pitotbench.show.short_answer import ShortAnswer


@dataclass(frozen=True, slots=True)
class Section:
    """A part of a page: its anchor, the group and the title in the page's index, its short answer, its HTML."""

    anchor: str
    group: str
    title: str
    answer: ShortAnswer
    html: str
