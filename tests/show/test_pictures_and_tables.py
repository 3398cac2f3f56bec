"""Pictures and tables: what a reader needs is on them, with units, and nothing is cut or covered."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from rich.console import Console
from tests.calibration import trajectories as fixture

from pitotbench.campaigns.flights import tolerances
from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.legs import FixedSpeedPoint
from pitotbench.show.calibration import short_answer_of
from pitotbench.show.calibration_tree import calibration_tree
from pitotbench.show.campaign import campaign_tree
from pitotbench.show.columns import print_table
from pitotbench.show.curve_rows import off_curve, points_json
from pitotbench.show.curves import (
    bound_panels,
    curve_panels,
    residual_autocorrelation,
    residual_panels,
)
from pitotbench.show.flights import flight_panels
from pitotbench.show.pages import log_page, log_section
from pitotbench.show.style import NARROW, WIDE, Panel, broken, stacked, thin
from pitotbench.show.tree import Sentence, Table, nodes_in
from pitotbench.units import KNOT


def _words(panels: list[Panel]) -> str:
    drawn = " ".join(
        text for p in panels for text in re.findall(r"<text[^>]*>([^<]*)</text>", p.drawing)
    )
    return drawn + " ".join(f"{p.title} {p.note}" for p in panels)


def test_panels_carry_units_truth_and_the_limit(result):
    truth = result.curve.correction
    (drawn,) = curve_panels({"inverse+": result}, {"inverse+": truth})
    text = _words([drawn, *bound_panels(result, truth)])
    for wanted in (
        "Error curve",
        "indicated airspeed [kt]",
        "FAR 23.1323(b)",
        "truth",
        "2σ for white residuals",
    ):
        assert wanted in text
    text = _words(residual_panels(result))
    for wanted in ("Data density", "lag [s]", "time [min]", "measured − predicted [kt]"):
        assert wanted in text


@pytest.fixture(scope="module")
def point():
    return FixedSpeedPoint(
        method="four_leg", legs=4, seconds=40.0, indicated_airspeed=130.0 * KNOT, calibrated_airspeed=129.0 * KNOT,
        correction=-1.0 * KNOT, two_sigma=0.25 * KNOT, true_airspeed=140.0 * KNOT,
        true_airspeed_two_sigma=0.3 * KNOT, spread=None, wind_north=0.0, wind_east=-10.0 * KNOT,
        wind_two_sigma=0.4 * KNOT,
    )  # fmt: skip


def test_fixed_speed_points_are_on_the_curve_and_in_numbers(log, result, point):
    assert "four-leg, ±2σ" in _words(
        curve_panels({"inverse+": replace(result, points=(point,))}, None)
    )
    assert "four-leg" not in _words(curve_panels({"inverse+": result}, None))
    assert "four-leg" in log_section("a.csv", log, replace(result, points=(point,))).html
    (plain,) = points_json([point])
    assert plain["correction_kt"] == pytest.approx(-1.0)
    assert plain["wind_from_deg"] == pytest.approx(90.0)
    assert plain["spread_kt"] is None


def test_the_table_of_points_says_how_far_each_is_off_the_curve(result, point, capsys):
    curve = result.curve
    on_curve = float(
        np.interp(point.indicated_airspeed, curve.indicated_airspeed, curve.correction)
    )
    moved = [replace(point, correction=on_curve + 0.5 * KNOT)]
    tree = calibration_tree("", {"inverse+": replace(result, points=tuple(moved))})
    tables = [n for n in nodes_in([tree]) if isinstance(n, Table) and n.rows == tuple(moved)]
    print_table(tables[0].columns, moved, Console(width=80))
    row = capsys.readouterr().out.splitlines()[-1]
    assert row.startswith("four-leg")
    assert row.split()[-1] == "+0.50"


def test_between_round_airspeeds_the_curve_is_no_straight_line(point):
    """Half-way between points 10 kt apart a parabola of 1 kt at 10 kt lies 0.25 kt below its chord."""
    speed = np.arange(100.0, 161.0, 10.0) * KNOT
    bent = ((speed - 130.0 * KNOT) / (10.0 * KNOT)) ** 2 * KNOT
    flat = np.zeros_like(speed)
    curve = ErrorCurve(speed, bent, flat, flat, flat, flat, flat)
    half_way = replace(point, indicated_airspeed=135.0 * KNOT, correction=0.25 * KNOT)
    assert off_curve(curve, half_way) == pytest.approx(0.0, abs=0.005)


def test_flight_panels_show_wind_and_tolerances(smooth_flights):
    flight = smooth_flights["rapid_decel"]
    text = _words(flight_panels(flight, tolerances(flight.case)))
    assert "15 kt" in text
    assert "tolerance ±50 ft" in text
    assert "altitude [ft]" in text


def test_answer_gives_curve_and_wind_with_their_bounds(result):
    answer = short_answer_of(result, "step decrease 10/10")
    assert answer.wind_kt == pytest.approx(
        np.hypot(*fixture.WIND) / KNOT, abs=3.0 * answer.wind_two_sigma_kt
    )
    assert [c.indicated_kt for c in answer.corrections] == sorted(
        c.indicated_kt for c in answer.corrections
    )
    assert all(c.two_sigma_kt > 0.0 for c in answer.corrections)


def test_log_page_is_whole_and_self_contained(log, result):
    page = log_page("A log", [log_section("a & b.csv", log, result)])
    assert "a &amp; b.csv" in page
    assert "From a measured log" in page
    assert "<svg" in page
    assert not re.search(r'src=|<link|<script|href="https?:', page)


def test_remarks_tell_the_smallest_residual_from_the_best_known_curve():
    row = {"model": "inverse+", "das": "20/1", "curve_coverage": 1.0, "on_condition_share": 1.0}
    row |= {"minutes": 8.0, "curve_rms_error_kt": 0.05}
    table = pd.DataFrame(
        [
            row | {"maneuver": "step_decrease", "residual_two_sigma_kt": 0.5, "two_sigma_kt": 0.4},
            row | {"maneuver": "four_leg", "residual_two_sigma_kt": 0.9, "two_sigma_kt": 0.1},
        ]
    )
    best, sentence = (node.text for node in campaign_tree(table) if isinstance(node, Sentence))
    assert best.startswith("Four leg at 20/1 Hz has the narrowest bound: ±0.10 kt")
    assert "do not choose a maneuver by its residual" in sentence


def test_a_bound_that_its_truth_contradicts_is_not_called_the_best():
    row = {"model": "inverse+", "das": "20/1", "residual_two_sigma_kt": 0.5, "minutes": 5.2}
    table = pd.DataFrame(
        [
            row | {"maneuver": name, "two_sigma_kt": bound, "curve_rms_error_kt": error, "curve_coverage": inside}
            for name, bound, error, inside in (
                ("race_track", 0.09, 0.072, 0.77),
                ("circle", 0.12, 0.05, 1.0),
                ("four_leg", 0.2, 0.04, 1.0),
            )
        ]
    )  # fmt: skip
    sentence = next(node.text for node in campaign_tree(table) if isinstance(node, Sentence))
    assert "best" not in sentence
    assert sentence.startswith("Race track at 20/1 Hz claims the narrowest bound, ±0.09 kt")
    assert "twice its true rms error is 0.14 kt, and 77 % of the true curve is inside" in sentence
    assert sentence.endswith("bears out: Circle at 20/1 Hz, ±0.12 kt (mean 2σ) in 5.2 min.")
    none_holds = campaign_tree(table.assign(curve_rms_error_kt=0.3))[0].text
    assert none_holds.endswith("No bound of the others holds twice its true error.")


def test_autocorrelation_of_a_gust_is_long(result):
    lags, values, count = residual_autocorrelation(result)
    assert lags[0] == 0.0
    assert values[0] == 1.0
    assert values[2] > 4.0 / np.sqrt(count)  # eight seconds of memory: far from white


def test_lines_are_thinned_and_broken_at_pauses():
    time = np.concatenate([np.arange(0.0, 10.0, 0.01), np.arange(60.0, 70.0, 0.01)])
    short, _ = thin(time, time)
    assert len(short) <= 2000
    gapped, value = broken(time, time)
    assert np.isnan(value).sum() == 1
    assert len(gapped) == len(time) + 1


X = np.linspace(0.0, 9.7, 50)


def plain(axes):
    axes.plot(X, np.sin(X), label="curve")
    axes.fill_between(X, np.sin(X) - 1.0, np.sin(X) + 1.0, label="±2σ")
    axes.set(xlabel="indicated airspeed [kt]", ylabel="correction [kt]")


def large_numbers(axes):
    axes.plot(1e5 * X, -12345.6 * X, label="a name")
    axes.set(xlabel="x", ylabel="y")


def named_bars(axes):
    axes.bar([0, 1], [1.0, 2.0], label="first")
    axes.set_xticks([0, 1], ["step\ndecrease", "a maneuver of\nthree\nlines"])
    axes.grid(axis="x", visible=False)
    axes.set_ylabel("2σ [kt]")


def logarithmic(axes):
    axes.plot(X + 0.01, 1e4 * (X + 0.01) ** 3)
    axes.set(xscale="log", yscale="log", xlabel="x", ylabel="y")
    axes.set_xlim(0.5, 20.0)


def with_words(axes):
    axes.plot(X, X, label="line")
    axes.text(9.0, 5.0, "words that reach far beyond the axes")


def many_names(axes):
    for number, name in enumerate(
        ("samples without the wind", "short", "±2σ of the curve", "limit of FAR 25.1323(c)")
    ):
        axes.plot(X, number * X, label=name)


@pytest.mark.parametrize("size", [WIDE, NARROW])
@pytest.mark.parametrize(
    "draw", [plain, large_numbers, named_bars, logarithmic, with_words, many_names]
)
def test_nothing_is_cut_and_the_legend_covers_nothing(draw, size):
    with stacked([draw], size, 3) as figure:
        figure.draw_without_rendering()
        box = figure.get_tightbbox()
        assert box.x0 >= -0.01
        assert box.y0 >= -0.01
        assert box.x1 <= size[0] + 0.01
        assert box.y1 <= size[1] + 0.01
        (axes,) = figure.axes
        for legend in figure.legends:
            assert legend.get_window_extent().y0 >= axes.get_window_extent().y1


def test_two_axes_leave_room_for_the_ticks_between_them():
    with stacked([plain, large_numbers], (4.6, 4.4), 2) as figure:
        figure.draw_without_rendering()
        upper, lower = figure.axes
        assert upper.get_tightbbox().y0 >= lower.get_window_extent().y1
        assert upper.get_position().x0 == lower.get_position().x0
        assert upper.get_xlim() == lower.get_xlim()


def test_long_names_take_fewer_columns():
    def named(axes):
        for number in range(3):
            axes.plot(X, number * X, label=f"name {number} of some length")

    left = {}
    for width in (20.0, 4.0, 2.0):
        with stacked([named], (width, 2.9), 3) as figure:
            figure.draw_without_rendering()
            (legend,) = figure.legends
            left[width] = len({round(text.get_window_extent().x0) for text in legend.get_texts()})
    assert left == {20.0: 3, 4.0: 2, 2.0: 1}
