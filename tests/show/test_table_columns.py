"""One description of a table's columns for terminal, HTML, Markdown and JSON; texts from outside
act nowhere.
"""

import json
import re
from dataclasses import replace
from io import StringIO

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.forecast import Forecast, Plan
from pitotbench.show.campaign import CAMPAIGN_COLUMNS, campaign_tree
from pitotbench.show.columns import (
    Column,
    command_line,
    frame_rows,
    html_table,
    json_rows,
    json_text,
    outside,
    print_table,
    printable,
    with_minus_signs,
)
from pitotbench.show.curve_rows import CURVE_COLUMNS, POINT_COLUMNS, curve_points
from pitotbench.show.plan import plan_columns, plan_tree
from pitotbench.show.renderers import print_tree
from pitotbench.units import KNOT
from pitotlab.tables import frame_columns, markdown_table

COLUMNS = (
    Column("name", lambda row: row["name"], key="name"),
    Column("long heading of a share", lambda row: row["share"], "%", ".0%", "share"),
    Column("", lambda row: 7, key="hidden"),
    Column("shown only", lambda row: row["speed"], "kt", "+.1f"),
)
ROWS = (
    {"name": "a|<b>", "share": 0.981, "speed": 2.0},
    {"name": "\x1b[31m", "share": None, "speed": -3.25},
)


def _printed(show, width: int = 80) -> str:
    stream = StringIO()
    show(Console(file=stream, highlight=False, width=width))
    return stream.getvalue()


def terminal_lines(columns, rows):
    """The lines of a table in a pipe, and how many of them are the heading."""
    lines = [
        line.rstrip()
        for line in _printed(lambda console: print_table(columns, rows, console)).splitlines()
    ]
    return lines, next(number for number, line in enumerate(lines) if "─" in line)


def test_every_renderer_shows_the_same_cells():
    lines, above = terminal_lines(COLUMNS, ROWS)
    assert lines[above - 1].split() == [
        "name",
        "[%]",
        "[kt]",
    ]  # units on the last line of the heading
    assert set(lines[above]) == {"─", " "}
    assert lines[above + 1].split() == ["a|<b>", "98", "+2.0"]
    assert "<td>98</td><td>+2.0</td>" in html_table(COLUMNS, ROWS)
    assert markdown_table(COLUMNS, ROWS).splitlines()[2] == r"| a\|<b> | 98 | +2.0 |"
    assert json_rows(COLUMNS, ROWS)[0] == {"name": "a|<b>", "share": 0.981, "hidden": 7}
    # A text from outside is neither markup nor a control code; an absent value is a dash and null.
    assert "\x1b" not in "".join(lines)
    assert "a|&lt;b&gt;" in html_table(COLUMNS, ROWS)
    assert lines[-1].split()[1] == "–"
    assert json_rows(COLUMNS, ROWS)[1]["share"] is None
    # A correction that is rounded to nought has no minus sign, and a table of no rows prints
    # nothing.
    assert [Column("x", lambda r: r, "ft", "+.0f").text(value) for value in (-0.4, -0.6)] == [
        "+0",
        "-1",
    ]
    assert _printed(lambda console: print_table(COLUMNS, [], console, "title")) == ""


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ("by -6.1 kt (-50σ), -3 to -2.5e-3", "by −6.1 kt (−50σ), −3 to −2.5e-3"),
        ("2026-11-26, step-3, --to 2:30, G3X-2, -2b", "2026-11-26, step-3, --to 2:30, G3X-2, -2b"),
    ],
)
def test_a_negative_number_has_a_minus_sign_and_a_name_keeps_its_hyphen(written, read):
    assert with_minus_signs(written) == read


def test_an_optional_column_without_a_value_is_not_shown():
    rows = [{"x": 1, "y": None}]
    columns = [
        Column("x", lambda r: r["x"]),
        Column("y", lambda r: r["y"], "ft", ".1f", "y", optional=True),
    ]
    assert "y" not in "".join(terminal_lines(columns, rows)[0])
    assert "y" not in markdown_table(columns, rows)
    assert json_rows(columns, rows) == [{}]
    assert "[ft]" in markdown_table(columns, [{"x": 1, "y": 2.0}])


def test_a_frame_keeps_its_headings_and_its_whole_numbers():
    table = pd.DataFrame({"maneuver": ["circle"], "mean 2σ [kt]": [0.123456], "flights": [1000]})
    (column,) = [c for c in frame_columns(table) if c.unit]
    assert (column.heading, column.unit) == ("mean 2σ", "kt")
    assert markdown_table(frame_columns(table, ".3g"), frame_rows(table)).splitlines()[2] == (
        "| circle | 0.123 | 1000 |"
    )


def _forecast(name: str) -> Forecast:
    speeds = np.array([100.0, 160.0]) * KNOT
    bounds = np.array([0.3, 0.2]) * KNOT
    return Forecast(
        name, {}, 12.25, 15.5, 0.5, (9e3, 8e3), speeds, bounds, bounds, 0.01, np.zeros((2, 2))
    )


def _plan() -> Plan:
    forecasts = (_forecast("step_both_ways"), _forecast("figure_eight"))
    return Plan("the conditions", forecasts, {}, *forecasts, None, 0, want=0.2 * KNOT, minutes=20.0)


def _campaign() -> pd.DataFrame:
    texts = {"maneuver": "step_decrease", "das": "100/100", "model": "inverse+"}
    return pd.DataFrame([{c.key: texts.get(c.key, 12345.678) for c in CAMPAIGN_COLUMNS}])


@pytest.mark.parametrize("width", [20, 80])
@pytest.mark.parametrize(
    ("show", "columns", "last"),
    [
        (
            lambda console: print_tree(plan_tree(_plan()), console),
            plan_columns(_plan()),
            "best, no steep turn",
        ),
        (
            lambda console: print_tree(campaign_tree(_campaign()), console),
            CAMPAIGN_COLUMNS,
            "1234568",
        ),
    ],
)
def test_a_table_in_a_pipe_is_never_cut(show, columns, last, width):
    text = _printed(show, width)
    assert "…" not in text
    assert text.splitlines()[-1].rstrip().endswith(last)
    for word in " ".join(column.heading for column in columns).split():
        assert word in text


def test_the_headings_of_one_table_differ_and_say_what_each_2σ_is():
    for columns in (
        CAMPAIGN_COLUMNS,
        CURVE_COLUMNS,
        POINT_COLUMNS,
        plan_columns(_plan()),
    ):
        headings = [column.heading for column in columns if column.heading]
        assert len(set(headings)) == len(headings)
        assert not {"2σ", "±2σ", "±"} & set(headings)
        assert "-" not in {column.unit for column in columns}


def test_the_curve_in_numbers_fits_80_columns_and_gives_calibrated_airspeed():
    speed = np.array([100.0, 160.0]) * KNOT
    curve = ErrorCurve(
        speed, 0.01 * speed, *[0.002 * speed] * 3, *[np.array([-0.0123, 0.0123])] * 2
    )
    lines, _ = terminal_lines(CURVE_COLUMNS, curve_points(curve))
    assert max(map(len, lines)) <= 80
    assert re.match(r" *160 +161\.60 +\+1\.60 ", lines[-1])
    assert json_rows(CURVE_COLUMNS, curve_points(curve))[1][
        "calibrated_airspeed_kt"
    ] == pytest.approx(161.6)


def test_the_altitude_correction_is_in_feet_and_only_where_the_static_source_errs():
    speed = np.array([100.0, 160.0]) * KNOT
    curve = ErrorCurve(speed, *[0.01 * speed] * 4, *[np.array([-0.0123, 0.0123])] * 2)
    static = replace(
        curve,
        altitude_correction=np.array([3.048, -6.096]),
        altitude_two_sigma=np.array([3.048, 3.048]),
    )
    rows = json_rows(CURVE_COLUMNS, curve_points(static))
    assert [row["altitude_correction_ft"] for row in rows] == pytest.approx([10.0, -20.0])
    assert [row["two_sigma_ft"] for row in rows] == pytest.approx([10.0, 10.0])
    assert terminal_lines(CURVE_COLUMNS, curve_points(static))[0][-1].split()[-2:] == ["-20", "10"]
    assert "two_sigma_ft" not in json_rows(CURVE_COLUMNS, curve_points(curve))[0]
    assert "[ft]" not in "".join(terminal_lines(CURVE_COLUMNS, curve_points(curve))[0])


def test_json_is_strict_ends_in_a_line_break_and_keeps_every_digit():
    document = {
        "a": [float("nan"), (np.float64("inf"), 1.5)],
        "b": {"c": -float("inf")},
        "d": "inf",
        "e": True,
    }
    expected = {"a": [None, [None, 1.5]], "b": {"c": None}, "d": "inf", "e": True}
    assert json.loads(json_text(document), parse_constant=pytest.fail) == expected
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
    assert printable("a\n\x1bb", keep="\n") == "a\n\\x1bb"


def test_a_console_does_not_read_markup_in_a_text_from_outside():
    stream = StringIO()
    Console(
        file=stream, highlight=False, soft_wrap=True, force_terminal=True, color_system=None
    ).print(outside("[bold]x[/nothing] :bomb: \x1b[31m"))
    assert stream.getvalue() == "[bold]x[/nothing] :bomb: \\x1b[31m\n"


def test_a_command_is_quoted_for_the_shell_of_the_system():
    words = ["pitotbench", "calibrate", "my log.csv", "a&b.csv", "18±2@ground"]
    posix = "pitotbench calibrate 'my log.csv' 'a&b.csv' '18±2@ground'"
    assert command_line(words, "posix") == posix
    assert command_line(words, "nt") == 'pitotbench calibrate "my log.csv" "a&b.csv" 18±2@ground'
