"""The error curve that answers to the pointer: the numbers of the drawn one, and the drawn one without Plotly."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
import trajectories as fixture

from pitotbench.calibrate import calibrate
from pitotbench.records.fixed_speed_point import FixedSpeedPoint
from pitotbench.show import live_curve as live
from pitotbench.show.draw_section import log_section
from pitotbench.show.report import log_page
from pitotbench.units import KNOT


@pytest.fixture(scope="module")
def log():
    return fixture.fly(fixture.circles(2), 2, 2, fixture.Air())


@pytest.fixture(scope="module")
def result(log):
    return calibrate(log)


def test_the_live_picture_holds_the_numbers_of_the_curve(log, result):
    pytest.importorskip("plotly", reason="needs the extra pitotbench[interactive]")
    section = log_section("a.csv", log, result)
    (text,) = re.findall(r"Plotly\.newPlot\(place, \.\.\.(.*)\);", section.html)
    traces, layout, _ = json.loads(text)
    (curve,) = [trace for trace in traces if trace["name"].startswith("curve")]
    np.testing.assert_allclose(curve["x"], result.curve.indicated_airspeed / KNOT)
    np.testing.assert_allclose(curve["y"], result.curve.correction / KNOT)
    np.testing.assert_allclose(curve["customdata"], result.curve.two_sigma / KNOT)
    assert layout["yaxis"]["title"]["text"].endswith("[kt]")
    page = log_page("a", [section, section])
    assert page.count("<svg") > 0
    assert page.count(live.live_script()) == 1


def test_the_page_needs_nothing_from_the_network(log, result):
    page = log_page("a", [log_section("a.csv", log, result)]).replace(live.live_script() or "none", "")
    assert "src=" not in page
    assert "<link" not in page


def test_the_points_of_a_method_have_one_entry_in_the_legend(result):
    """And the marker of the drawing's method."""
    pytest.importorskip("plotly", reason="needs the extra pitotbench[interactive]")
    turn = FixedSpeedPoint(
        method="turn", legs=1, seconds=40.0, indicated_airspeed=60.0, calibrated_airspeed=60.5, correction=0.5,
        two_sigma=0.2, true_airspeed=66.0, true_airspeed_two_sigma=0.1, spread=None, wind_north=0.0,
        wind_east=0.0, wind_two_sigma=0.1,
    )  # fmt: skip
    points = [turn, replace(turn, indicated_airspeed=70.0), replace(turn, method="four_leg")]
    traces = json.loads(live.live_curve(result, points))[0]
    named = {trace["name"]: trace for trace in traces if trace["mode"] == "markers" and "error_y" in trace}
    assert {name: trace["marker"]["symbol"] for name, trace in named.items()} == {
        "turn, ±2σ": "circle",
        "four-leg, ±2σ": "square",
    }
    assert len(named["turn, ±2σ"]["x"]) == 2
    assert all(trace.get("showlegend", True) for trace in named.values())


def test_a_limit_named_like_a_script_stays_text(log, result):
    pytest.importorskip("plotly", reason="needs the extra pitotbench[interactive]")
    limit = live.Limit("</script><b>", 0.03, 5.0)
    assert "</script>" not in live.live_curve(result, (), limit)


def test_without_plotly_the_page_has_the_drawn_picture_alone(log, result, monkeypatch):
    monkeypatch.setattr(live, "find_spec", lambda name: None)
    section = log_section("a.csv", log, result)
    page = log_page("a", [section])
    assert not section.live
    assert "<script" not in page
    assert 'aria-label="Error curve"' in page
