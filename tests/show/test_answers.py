"""The sentences of an answer: what the certification rule says of a curve, where a log comes from, what to fly."""

from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
import trajectories as fixture
from rich.console import Console

from pitotbench.calibrate import calibrate
from pitotbench.records.calibration import Estimate, Share
from pitotbench.show.calibration_text import print_calibration
from pitotbench.show.draw_section import log_section
from pitotbench.show.error_curves import curve_panels
from pitotbench.show.far_limit import far_applies, far_limit, far_verdict
from pitotbench.show.quantity_words import entry_words
from pitotbench.show.report import log_page
from pitotbench.units import KNOT


@pytest.fixture(scope="module")
def log():
    return fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air())


@pytest.fixture(scope="module")
def result(log):
    return calibrate(log)


def _with_curve(result, correction_kt, two_sigma_kt):
    """The result with another curve: constant correction and bound over its airspeeds."""
    ones = np.ones(len(result.curve.indicated_airspeed))
    correction, bound = correction_kt * KNOT * ones, two_sigma_kt * KNOT * ones
    return replace(result, curve=replace(result.curve, correction=correction, two_sigma=bound))


def _terminal(result) -> str:
    stream = StringIO()
    print_calibration(result, Console(file=stream, highlight=False, soft_wrap=True, width=80))
    return stream.getvalue()


def test_the_far_limit_is_the_larger_of_3_percent_and_5_knots():
    assert far_limit(np.array([100.0, 200.0])).tolist() == [5.0, 6.0]


@pytest.mark.parametrize(
    ("correction", "bound", "says"),
    [
        (-3.0, 0.5, "stay inside, with a margin of 1.5 kt"),
        (4.0, 1.4, "exceeds the limit by up to 0.4 kt"),
        (-6.0, 0.5, "the curve exceeds the limit by up to 1.0 kt"),
    ],
)
def test_the_verdict_on_the_far_limit_gives_the_margin(result, correction, bound, says):
    assert says in far_verdict(_with_curve(result, correction, bound))
    assert says in _terminal(_with_curve(result, correction, bound))


def test_the_far_limit_does_not_judge_a_drone(result):
    slow = replace(result.curve, indicated_airspeed=result.curve.indicated_airspeed / 4.0)
    drone = replace(result, curve=slow)
    assert far_applies(result)
    assert "FAR" not in _terminal(drone)
    assert not any("FAR" in panel.title for panel in curve_panels({"inverse+": drone}, None))


def test_the_terminal_answers_in_a_sentence_first(result):
    first, second, *_ = _terminal(result).splitlines()
    assert first.startswith("Add ")
    assert "KIAS" in first
    assert second.startswith("The wind is ")
    assert " from " in second


def test_a_stated_accuracy_is_named_with_its_part_of_both_bounds(result):
    share = Share("impact_pressure_zero_pa", Estimate("zero", 102.0, 9.99), 2.44 * KNOT, 0.76 * KNOT)
    text = _terminal(replace(result, shares=(share,)))
    assert "impact_pressure_zero_pa (estimated +102 ± 9.99) contributes ±2.44 kt to the curve" in text
    assert "±0.76 kt to the wind" in text


@pytest.mark.parametrize(("header", "origin"), [({}, "measured log"), ({"case": {}}, "simulated log")])
def test_a_page_says_whether_its_log_was_measured(log, result, header, origin):
    section = log_section("a.csv", replace(log, header=header), result)
    assert f"<p>From a {origin}</p>" in log_page("A log", [section])
    assert f"<p>From {origin}s</p>" in log_page("Two logs", [section, section])


def test_a_card_is_written_for_a_pilot():
    assert entry_words("turns", [0.6182, 1.469, 1.038]) == "turns 0.618, 1.47, 1.04 circles"
    assert entry_words("bank_deg", 45.0) == "bank 45°"
    assert entry_words("speeds_kt", [160.0, 128.0]) == "speeds 160, 128 kt"
