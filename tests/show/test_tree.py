"""The tree of an answer, its renderers, and the units of the reader."""

from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
from matplotlib.figure import Figure as Drawing
from rich.console import Console
from tests.calibration import trajectories as fixture

from pitotbench import calibrate
from pitotbench.calibration.flown_tracks import one_sided
from pitotbench.records import BadInputError
from pitotbench.show.columns import Column
from pitotbench.show.reader_units import BENCH, QUOTED, Units, reader_units, units_named
from pitotbench.show.renderers import html_of, print_tree
from pitotbench.show.style import panel
from pitotbench.show.tree import (
    ANSWER,
    NUMBERS,
    SOURCES,
    Doubt,
    Download,
    Figure,
    Heading,
    Notice,
    Sentence,
    Table,
)
from pitotbench.units import DEGREE, KNOT

METRIC = units_named("km/h,m,degf,hpa")


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ("Add +2.16 ± 1.64 kt at 58 KIAS.", "Add +4.00 ± 3.04 km/h at 107 km/h IAS."),
        ("from 58 to 116 KIAS", "from 107 to 215 km/h IAS"),
        ("known to ±2.55 kt (2σ)", "known to ±4.72 km/h (2σ)"),
        ("2,500 to 12,000 ft", "762 to 3,658 m"),
        # A rule keeps its own units: its numbers are no quantities of the answer.
        (f"30{QUOTED}ft for each 100{QUOTED}kt", "30 ft for each 100 kt"),
        (f"3 % and 5{QUOTED}kt, by up to 2 kt", "3 % and 5 kt, by up to 4 km/h"),
        ("−3.00 kt, -16.1 kt", "−5.56 km/h, −29.8 km/h"),
        ("18 °C at 29.92 inHg", "64 °F at 1013.21 hPa"),
        ("indicated_airspeed_kt is 5 kts; 6 Pa, 2 ft/s, log5 kt.csv", None),
    ],
)
def test_a_text_is_read_in_the_units_of_the_reader(written, read):
    assert METRIC.text(written) == (written if read is None else read)
    assert BENCH.text(written) == written.replace(QUOTED, " ").replace("-16.1", "−16.1")


def test_a_drone_is_read_in_meters_per_second():
    assert units_named("m/s").text("Add +2.16 kt at 58 KIAS.") == "Add +1.11 m/s at 30 m/s IAS."


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ("is -6.1 ± 0.2 kt (-3 %), by -1.", "is −6.1 ± 0.2 kt (−3 %), by −1."),
        ("-1.2e-05, -2,500 ft", "−1.2e-05, −2,500 ft"),
        ("2026-11-26, 14:00-15:30, --track-deg=-5, -3.csv, log-4 of 501-1000, +/-2", None),
    ],
)
def test_every_voice_writes_minus_signs_before_numbers_and_hyphens_elsewhere(written, read):
    assert BENCH.text(written) == (written if read is None else read)
    assert Column("", lambda row: row).text(written) == (written if read is None else read)


def test_a_column_keeps_its_digits_and_its_gaps():
    columns = [
        Column("KIAS", lambda row: row[0], "", ".0f"),
        Column("correction", lambda row: row[1], "kt", "+.2f"),
        Column("height", lambda row: row[2], "ft", ",.0f"),
        Column("why", lambda row: row[3]),
    ]
    rows = [(100.0, 0.001, 12345.0, "at 100 KIAS"), (57.6, None, 10.0, "")]
    metric = METRIC.columns(columns)
    assert [each.title for each in metric] == [
        "IAS [km/h]", "correction [km/h]", "height [m]", "why",
    ]  # fmt: skip
    assert [[each.text(row) for each in metric] for row in rows] == [
        ["185", "+0.00", "3,763", "at 185 km/h IAS"],
        ["107", "–", "3", ""],
    ]
    same = BENCH.columns(columns)
    assert [each.text(rows[0]) for each in same] == [each.text(rows[0]) for each in columns]


def test_an_axis_has_round_numbers_of_the_readers_unit():
    axes = Drawing().subplots()

    def draw(inner):
        inner.plot([50.0, 120.0], [0.0, 1.0])
        inner.set(xlabel="indicated airspeed [kt]", ylabel="time [min]")

    drawn = panel("It", draw, units=METRIC).drawing
    assert "indicated airspeed [km/h]" in drawn
    assert "time [min]" in drawn
    assert ">100<" in drawn
    assert ">200<" in drawn
    assert "[km/h]" not in panel("It", draw).drawing
    draw(axes)
    assert axes.get_xlabel() == "indicated airspeed [kt]"


@pytest.mark.parametrize("text", ["km", "kt,km/h", "ft,m", "knots,,"])
def test_units_that_are_none_or_two_of_a_kind_are_refused(text):
    with pytest.raises(BadInputError, match="--units"):
        units_named(text)


def test_the_line_of_the_configuration_is_used_where_nobody_states_units(tmp_path, monkeypatch):
    path = tmp_path / "pitotbench.toml"
    monkeypatch.setenv("PITOTBENCH_CONFIG", str(path))
    assert (reader_units(), reader_units().source) == (BENCH, "default")
    path.write_text('units = "km/h,m"\n', encoding="utf-8")
    found, stated = reader_units(), reader_units("mph")
    assert (found.words, found.source) == ("km/h,m,degc,inhg", "pitotbench.toml")
    assert (stated.words, stated.source) == ("mph,ft,degc,inhg", "stated")
    for line in ("units = km/h", 'units = "furlong"'):
        path.write_text(line, encoding="utf-8")
        with pytest.raises(BadInputError, match=r'pitotbench\.toml.*write units = "km/h,m"'):
            reader_units()


def test_units_that_nobody_named_are_those_of_the_bench():
    assert units_named("") == BENCH
    assert units_named("MPH,hPa") == Units(speed="mph", pressure="hpa")


def pictures(values, units):
    return [panel("a picture", lambda axes: axes.plot(values), units=units)]


TREE = (
    Sentence("a sentence"),
    Figure(f"{__name__}.pictures", ([0.0, 1.0],)),
    Doubt("the first doubt", first=True),
    Table([Column("n", lambda row: row, "", "d")], [41]),
    Download("card.csv", "a file", "n\n41\n"),
    Doubt("a doubt <b>"),
    Notice("a notice"),
    Heading("sources", (Sentence("a source"), Doubt("a doubt below")), SOURCES),
    Heading("numbers", (Sentence("a number"),), NUMBERS),
)


def printed(depth):
    stream = StringIO()
    print_tree(TREE, Console(file=stream, width=80), depth=depth)
    return stream.getvalue()


def test_a_renderer_leaves_out_by_kind_and_by_depth_and_no_doubt_at_its_depth():
    short, middle, full = map(printed, (ANSWER, SOURCES, NUMBERS))
    for text in (short, middle, full):
        assert "a sentence" in text
        assert "\nthe first doubt\n" in text
        assert "warning: a doubt <b>\n" in text
        assert "41" in text
        assert "a picture" not in text
        assert "a file" not in text
    assert "a notice" not in short
    assert "Notes on what was read: 1" in short
    assert "note: a notice" in middle
    assert ["a source" in each for each in (short, middle, full)] == [False, True, True]
    assert ["a number" in each for each in (short, middle, full)] == [False, False, True]
    assert "warning: a doubt below" in middle
    page = html_of(TREE)
    places = [page.index(each) for each in ("a sentence", "<svg", "the first doubt", ">41<")]
    assert places == sorted(places)
    for text in (
        "a doubt &lt;b&gt;",
        "a notice",
        "a source",
        "a doubt below",
        "a number",
        "a file",
    ):
        assert text in page
    assert "a source" not in html_of(TREE, depth=ANSWER)


def test_the_speeds_that_were_flown_on_one_side_are_named():
    """Circles at 100 and 130 kt, then 160 kt eastward only."""
    at = np.array([0.0, 120.0, 180.0, 300.0, 360.0, 600.0])
    time = np.arange(600 * 5) / 5
    speed = np.interp(time, at, [100.0, 100.0, 130.0, 130.0, 160.0, 160.0]) * KNOT
    heading = np.interp(time, at, [0.0, 400.0, 400.0, 800.0, 810.0, 810.0]) * DEGREE
    log = fixture.fly((speed, heading), 5, 5, fixture.Air())
    found = calibrate(log)
    (fast,) = found.one_sided
    assert fast.high == found.curve.indicated_airspeed[-1]
    assert fast.low > 130.0 * KNOT
    assert fast.begin <= 90.0 <= fast.end
    assert "You flew only tracks" not in " ".join(map(str, found.warnings))
    circles = calibrate(fixture.fly(fixture.circles(5), 5, 5, fixture.Air()))
    assert circles.one_sided == ()
    shorter = replace(found, residuals=replace(found.residuals, used=np.ones(3, dtype=bool)))
    assert one_sided(log, shorter) == ()
