"""What the program prints: strict JSON, and texts from outside that a terminal does not obey."""

import json
from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from pitotbench.show.columns import json_text, outside, printable


def test_a_number_that_is_not_finite_becomes_null():
    document = {"a": [float("nan"), (np.float64("inf"), 1.5)], "b": {"c": -float("inf")}, "d": "inf", "e": True}
    expected = {"a": [None, [None, 1.5]], "b": {"c": None}, "d": "inf", "e": True}
    assert json.loads(json_text(document), parse_constant=pytest.fail) == expected


def test_json_ends_in_a_line_break_and_keeps_every_digit():
    assert json_text([0.1 + 0.2]) == "[\n 0.30000000000000004\n]\n"


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("\x1b[31mred", r"\x1b[31mred"),
        ("title\x07\r\n\t", r"title\x07\r\n\t"),
        ("\x9b2J", r"\x9b2J"),
        ("cs\u202evsc", r"cs\u202evsc"),
        ("lone \udce9", r"lone \udce9"),
        ("Δp/q_c ± 1 °, m² 東", "Δp/q_c ± 1 °, m² 東"),
    ],
)
def test_control_codes_are_written_out_and_letters_stay(text, written):
    assert printable(text) == written


def test_a_line_break_stays_where_it_is_wanted():
    assert printable("a\n\x1bb", keep="\n") == "a\n\\x1bb"


def test_a_console_does_not_read_markup_in_a_text_from_outside():
    stream = StringIO()
    Console(file=stream, highlight=False, soft_wrap=True, force_terminal=True, color_system=None).print(
        outside("[bold]x[/nothing] :bomb: \x1b[31m")
    )
    assert stream.getvalue() == "[bold]x[/nothing] :bomb: \\x1b[31m\n"
