"""Make texts from outside (file names, columns, segments, messages) safe to print on a terminal."""

from collections.abc import Iterable
from typing import TYPE_CHECKING
from unicodedata import category

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text

_CONTROLS = ("Cc", "Cs", "Zl", "Zp")  # control codes, lone surrogates, line and paragraph separators
_DIRECTIONS = frozenset("\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")  # turn text around


def printable(text: str, keep: str = "") -> str:
    r"""The text with every control code written out (`\x1b` for escape), save those to `keep`.

    A terminal obeys control codes: a column name could clear the screen or color what follows.
    """
    return "".join(_written(letter) if letter not in keep else letter for letter in text)


def outside(text: str, style: str = "") -> "Text":
    """One line of text from outside for a rich console or table: no markup, no emoji codes, no control codes."""
    from rich.text import Text

    return Text(printable(text), style=style)


def print_warnings(warnings: Iterable[str], console: "Console") -> None:
    """Print what changes the trust in an answer: below the answer's sentences, above its first table."""
    for warning in warnings:
        console.print(outside(f"warning: {warning}", "yellow"), soft_wrap=True)


def _written(letter: str) -> str:
    if category(letter) in _CONTROLS or letter in _DIRECTIONS:
        return letter.encode("unicode_escape").decode("ascii")
    return letter
