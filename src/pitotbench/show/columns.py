"""The columns of a table, described once for terminal, HTML, Markdown and JSON."""

import json
import os
import re
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from csv import DictWriter
from dataclasses import dataclass
from html import escape
from io import StringIO
from math import isfinite
from operator import itemgetter
from subprocess import list2cmdline
from typing import TYPE_CHECKING, Any, Generic, TypeVar
from unicodedata import category

if TYPE_CHECKING:
    from pandas import DataFrame
    from rich.console import Console
    from rich.text import Text


# Control codes, lone surrogates, line and paragraph separators.
_CONTROLS = ("Cc", "Cs", "Zl", "Zp")
# turn text around
_DIRECTIONS = frozenset("\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")


def printable(text: str, keep: str = "") -> str:
    r"""The text with every control code written out (`\x1b` for escape), save those to `keep`.

    A terminal obeys control codes: a column name could clear the screen or color what follows.
    """
    return "".join(
        letter.encode("unicode_escape").decode("ascii")
        if letter not in keep and (category(letter) in _CONTROLS or letter in _DIRECTIONS)
        else letter
        for letter in text
    )


_SHELL_LETTERS = frozenset("&|<>^()")  # of the command prompt of Windows


def command_line(words: Sequence[str], system: str = os.name) -> str:
    """Return a command as it is pasted into a POSIX shell, on Windows into the command prompt.

    Letters such as `&` mean something to the command prompt.
    """
    if system != "nt":
        return shlex.join(words)
    return " ".join(f'"{w}"' if _SHELL_LETTERS & set(w) else list2cmdline([w]) for w in words)


def outside(text: str, style: str = "") -> "Text":
    """Return one line of text from outside for a rich console or table.

    Markup, emoji codes and control codes do not act in it.
    """
    from rich.text import Text

    return Text(printable(text), style=style)


_NEGATIVE = re.compile(r"(?<![\w.\-/=\"'])-(?=\d[\d,]*(?:\.\d+)?(?:e[+-]\d+)?(?![^\Wσ]|[.-]\w))")


def with_minus_signs(text: str) -> str:
    """A text as it is read: with minus signs in the place of hyphens before numbers."""
    return _NEGATIVE.sub("−", text)


Row = TypeVar("Row")
_ABSENT = "–"


@dataclass(frozen=True, slots=True)
class Column(Generic[Row]):
    """One column of a table of rows of one kind.

    `heading` is the text above the column, without the unit; a column without a heading is in JSON
    only. `value` takes a row and returns a number, a text, a truth value, or None where the row has
    none. `style` is the format specification of the number; `.0%` shows a share in percent, for a
    column with the unit `%`. A column without a style holds text and is aligned left. `key` is the
    name in JSON; a column without a key is not in JSON.
    `optional`: the column is in the table, and in JSON, only where a row has a value.
    """

    heading: str
    value: Callable[[Row], object]
    unit: str = ""
    style: str = ""
    key: str = ""
    optional: bool = False

    def text(self, row: Row) -> str:
        """The cell of a row, without the unit.

        A text is as it is read; a number can be copied into a program, and a signed one that is
        rounded to nought is +0.
        """
        value = self.value(row)
        if value is None:
            return _ABSENT
        if isinstance(value, bool):
            return "yes" if value else "no"
        if not self.style:
            return with_minus_signs(str(value))
        return format(value, self.style.replace("+", "+z")).removesuffix("%")

    @property
    def title(self) -> str:
        """The heading with its unit, on one line."""
        return f"{self.heading} [{self.unit}]" if self.unit else self.heading


def keyed(
    key: str, heading: str, unit: str = "", style: str = "", optional: bool = False
) -> Column[dict[str, Any]]:
    """A column of rows that are dictionaries, by the key of its value."""
    return Column(heading, itemgetter(key), unit, style, key, optional)


def print_table(
    columns: Sequence[Column[Row]], rows: Iterable[Row], console: "Console", title: str = ""
) -> None:
    """Print a table to a terminal or a pipe with its title above, nothing without rows.

    Headings break between words where the terminal is narrow. No cell and no word is ever cut: a
    table that needs more is wider than the terminal.
    """
    from rich.box import Box
    from rich.measure import Measurement
    from rich.table import Table
    from rich.text import Text

    rows = list(rows)
    if not rows:
        return
    blank = "    \n"  # a rule stands below the heading, and nothing else is drawn
    table = Table(
        box=Box(2 * blank + " ─  \n" + 5 * blank),
        show_edge=False,
        pad_edge=False,
        header_style="bold",
    )
    cells = []
    for column in shown_columns(columns, rows):
        cells.append([Text(printable(column.text(row))) for row in rows])
        heading = Text(f"{column.heading}\n[{column.unit}]" if column.unit else column.heading)
        longest = max(text.cell_len for text in [*map(Text, heading.plain.split()), *cells[-1]])
        table.add_column(
            heading,
            justify="right" if column.style else "left",
            vertical="bottom",
            min_width=longest,
        )
    for line in zip(*cells, strict=True):
        table.add_row(*line)
    if title:
        console.print(Text(printable(title), style="bold"), soft_wrap=True)

    def least(gap: int) -> int:
        table.padding = (0, gap, 0, 0)
        return Measurement.get(console, console.options.update(width=10_000), table).minimum

    # The gaps are narrower only where that makes the table fit.
    if least(1) > console.width and least(0) > console.width:
        table.width = least(1)
    console.print(table, crop=False)


def html_table(columns: Sequence[Column[Row]], rows: Iterable[Row]) -> str:
    """A table as HTML that scrolls sideways on a narrow page; every text is escaped."""
    rows = list(rows)
    shown = shown_columns(columns, rows)
    head = "".join(f"<th{_kind(column)}>{_html_heading(column)}</th>" for column in shown)
    body = "".join(
        "<tr>"
        + "".join(f"<td{_kind(column)}>{escape(column.text(row))}</td>" for column in shown)
        + "</tr>\n"
        for row in rows
    )
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead>\n<tbody>{body}</tbody></table></div>'


def json_rows(columns: Sequence[Column[Row]], rows: Iterable[Row]) -> list[dict[str, Any]]:
    """The rows as plain data, by the keys of the columns."""
    rows = list(rows)
    keyed = [column for column in columns if column.key and not _empty(column, rows)]
    return [{column.key: column.value(row) for column in keyed} for row in rows]


def csv_text(rows: Sequence[Mapping[str, object]], **whole: object) -> str:
    """Rows as CSV, by key: numbers with three decimals, nothing for what a row has not.

    What is said of the `whole`, if anything, stands in the first row alone, in columns of its own.
    A text that a spreadsheet would take for a formula begins with an apostrophe.
    """
    said = {key: value for key, value in whole.items() if value}
    rows = [{**row, **(said if number == 0 else {})} for number, row in enumerate(rows)]
    keys = dict.fromkeys(sorted((key for row in rows for key in row), key=said.__contains__))
    text = StringIO()
    lines = DictWriter(text, keys, lineterminator="\n")
    lines.writeheader()
    for row in rows:
        lines.writerow(
            {k: f"{v:.3f}" if isinstance(v, float) else inert(v) for k, v in row.items()}
        )
    return text.getvalue()


def inert(value: Any) -> Any:
    """Return a cell that no spreadsheet takes for a formula, behind an apostrophe if needed."""
    formula = isinstance(value, str) and value.startswith(("=", "+", "-", "@", "\t", "\r"))
    return f"'{value}" if formula else value


def frame_rows(table: "DataFrame") -> list[dict[str, Any]]:
    """The rows of a frame, by column name."""
    return [{str(name): value for name, value in row.items()} for row in table.to_dict("records")]


def shown_columns(columns: Sequence[Column[Row]], rows: Sequence[Row]) -> list[Column[Row]]:
    """The columns with a heading, without optional ones that have no value."""
    return [column for column in columns if column.heading and not _empty(column, rows)]


def _empty(column: Column[Row], rows: Sequence[Row]) -> bool:
    """Whether the column is optional and no row has a value."""
    return column.optional and all(column.value(row) is None for row in rows)


def _kind(column: Column[Row]) -> str:
    return "" if column.style else ' class="text"'


def _html_heading(column: Column[Row]) -> str:
    heading = escape(column.heading).replace("q_c", "q<sub>c</sub>")
    return f"{heading}<br>[{escape(column.unit)}]" if column.unit else heading


def json_text(document: object) -> str:
    """Return a document as strict JSON (RFC 8259) that ends in a line break.

    The document is of mappings, sequences, text and numbers. A number that is not finite becomes
    null, because JSON cannot write it. Raises TypeError for anything else that JSON cannot hold.
    """
    return json.dumps(_finite(document), indent=1, allow_nan=False) + "\n"


# Of the answers: it counts up where a key of docs/contract.md goes or changes its meaning.
SCHEMA = 1


def answer_text(answer: Any) -> str:
    """An answer, or a list of answers, as strict JSON; each says by which schema it is."""
    if isinstance(answer, list):
        return json_text([{"schema": SCHEMA, **each} for each in answer])
    return json_text({"schema": SCHEMA, **answer})


def _finite(value: object) -> Any:
    if isinstance(value, float) and not isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return value
