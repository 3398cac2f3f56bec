"""The error curve that answers to the pointer: the numbers of the drawn one, and the drawn one without Plotly."""

import json
import re

import numpy as np
import pytest
import trajectories as fixture

from pitotbench.calibrate import calibrate
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
