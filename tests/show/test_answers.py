"""The sentences of an answer: the certification rule, where a log comes from, what a bound takes
for granted.
"""

import re
from csv import DictReader
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
from rich.console import Console
from tests.calibration import trajectories

from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.records import USUAL_ACCURACIES, BadInputError
from pitotbench.records.calibration import Disagreement, Estimate, Share
from pitotbench.records.log import Caution, CurveMove, InputFile, Provenance
from pitotbench.show.calibration import doubts_of, findings_of
from pitotbench.show.calibration_json import calibration_json
from pitotbench.show.calibration_tree import calibration_tree
from pitotbench.show.curve_rows import card_csv, glance_points
from pitotbench.show.limits import Limit, judgments, limit_for, limit_named
from pitotbench.show.pages import log_page, log_section
from pitotbench.show.renderers import html_of, print_tree
from pitotbench.show.tree import ANSWER, NUMBERS
from pitotbench.units import KNOT


def _with_curve(result, correction_kt, two_sigma_kt):
    """The result with another curve: constant correction and bound over its airspeeds."""
    ones = np.ones(len(result.curve.indicated_airspeed))
    correction, bound = correction_kt * KNOT * ones, two_sigma_kt * KNOT * ones
    return replace(result, curve=replace(result.curve, correction=correction, two_sigma=bound))


def _terminal(result, details=False) -> str:
    stream = StringIO()
    console = Console(file=stream, highlight=False, soft_wrap=True, width=80)
    tree = calibration_tree("", {result.model: result})
    print_tree(tree.nodes, console, depth=NUMBERS if details else ANSWER)
    return stream.getvalue()


@pytest.mark.parametrize(
    ("correction", "bound", "says"),
    [
        (-3.0, 0.5, "±2σ included: closest 1.5 kt"),
        (4.0, 1.4, "the ±2σ reaches 0.4 kt"),
        (-6.0, 0.5, "Outside FAR 23.1323(b) by up to 1.0 kt"),
    ],
)
def test_the_verdict_on_the_far_limit_gives_the_margin(result, correction, bound, says):
    assert says in judgments(_with_curve(result, correction, bound))[0].sentence
    assert says in _terminal(_with_curve(result, correction, bound))


def test_the_far_limit_does_not_judge_a_drone(result):
    slow = replace(result.curve, indicated_airspeed=result.curve.indicated_airspeed / 4.0)
    drone = replace(result, curve=slow)
    assert limit_for(result).name == "FAR 23.1323(b)"
    assert limit_for(replace(result, mach=0.6)).name == "FAR 25.1323(c)"
    assert "FAR" not in _terminal(drone)
    assert "FAR" not in drone._repr_html_()


@pytest.mark.parametrize("kind", ["drone", "glider"])
def test_no_rule_of_airplanes_judges_another_kind_of_aircraft(result, kind):
    """At the speeds of an airplane, too: what flew decides, as its recorder tells it."""
    made = Provenance((InputFile("log", "a.bin", "0" * 64, kind=kind),))
    other = replace(result, provenance=made)
    assert limit_for(other) is None
    for text in (_terminal(other), other._repr_html_()):
        assert "FAR" not in text
    assert limit_for(other, limit_named("far23")).name == "FAR 23.1323(b)"


def test_the_far_limit_is_the_larger_of_two_an_own_one_judges_in_its_place_and_none_nothing(result):
    rule = limit_named("far25")
    assert rule.airspeed(np.array([100.0, 200.0])).tolist() == [5.0, 6.0]
    assert rule.altitude(np.array([50.0, 200.0])).tolist() == [30.0, 60.0]
    curve = _with_curve(result, -1.5, 0.1)
    assert judgments(curve, limit_named("1%,1kt"))[0].verdict == "outside"
    assert judgments(curve, limit_named("1%,1.8kt,20ft"))[0].verdict == "inside"
    assert limit_named("2%,3kt,40ft") == Limit("Your limit", 0.02, 3.0, "Your limit", 40.0)
    assert judgments(curve, limit_named("none")) == []


@pytest.mark.parametrize("text", ["far99", "3%", "3%,5", "-3%,5kt", "3%,5kt,ft", "1.2.3%,5kt", ""])
def test_a_limit_that_cannot_be_read_is_refused(text):
    with pytest.raises(BadInputError, match="--limit"):
        limit_named(text)


def test_no_rule_judges_an_answer_that_is_not_to_be_used(result):
    wrong = Disagreement("samples", "the samples lie off the curve", 3.0 * KNOT, fatal=True)
    told = replace(result, disagreements=(wrong,))
    assert judgments(result)
    assert not judgments(told)
    first, second, *_ = _terminal(told).splitlines()
    assert first == "Do not use this answer: the samples lie off the curve."
    assert second.startswith("The wind is ")
    assert "FAR" not in _terminal(told)


def test_the_altitude_limit_judges_the_error_as_it_is_at_sea_level(result):
    """A static error of 1 % of q_c at 200 kt (6633.5 Pa) is 18.1 ft at sea level, where ρ g is
    12.01 Pa/m.
    """
    ones = np.ones(3)
    curve = replace(
        result.curve,
        **dict.fromkeys(
            ("correction", "two_sigma", "simultaneous_two_sigma", "white_two_sigma"), 0.0 * ones
        ),
        indicated_airspeed=200.0 * KNOT * ones,
        normalized_pressure_error=0.01 * ones,
        normalized_two_sigma=0.0 * ones,
        altitude_correction=30.0 * ones,
        altitude_two_sigma=ones,
    )
    found = judgments(replace(result, curve=curve))[1]
    assert found.rule == "FAR 23.1325(e)"
    assert found.with_bound.size == pytest.approx(60.0 - 18.1, abs=0.1)
    assert len(judgments(replace(result, curve=curve, place_assumed=True))) == 1, (
        "no rule judges what is assumed"
    )


def test_a_card_has_the_units_in_its_headings_and_the_numbers_of_the_curve(result):
    head, *rows = card_csv(result).splitlines()
    assert head.split(",")[:4] == [
        "indicated_airspeed_kt",
        "calibrated_airspeed_kt",
        "correction_kt",
        "two_sigma_kt",
    ]
    speed, calibrated, correction, bound = np.array(
        [row.split(",")[:4] for row in rows], dtype=float
    ).T
    assert calibrated - speed == pytest.approx(correction, abs=0.002)
    assert bound == pytest.approx(result.curve.two_sigma / KNOT, abs=0.001)


@pytest.mark.parametrize("airplane", ["=1+1", "+1", "@SUM(A1)", "\tN123"])
def test_a_card_holds_no_formula_of_a_log(result, airplane):
    """The header of a log names the airplane; a spreadsheet opens the card."""
    log = InputFile("log", "log.csv", "", airplane=airplane)
    card = card_csv(replace(result, provenance=Provenance(inputs=(log,))))
    (first, *_) = DictReader(StringIO(card))
    assert first["airplane"] == f"'{airplane}"


def test_the_terminal_answers_in_a_sentence_and_shows_the_curve_at_one_glance(result):
    short, full = _terminal(result), _terminal(result, details=True)
    first, second, *_ = short.splitlines()
    assert re.match("Add .*KIAS", first)
    assert re.match("The wind is .* from ", second)
    assert len(glance_points(result.curve)) <= 13
    assert "condition number" not in short
    assert "condition number" in full
    assert len(full.splitlines()) > len(short.splitlines())


@pytest.mark.parametrize(("share", "first"), [(0.3, True), (0.2, False), (None, True)])
def test_what_moves_the_answer_by_little_is_folded_and_its_size_is_told(result, share, first):
    moves = None if share is None else CurveMove(0.4 * KNOT, share)
    caution = Caution("the sensor lags", "outside prior", "latency", moves=moves)
    doubted = replace(result, warnings=(caution,))
    (finding,) = findings_of(doubted)
    assert (finding.moves, finding.first) == (moves and moves.most, first)
    said = "The sensor lags" in _terminal(doubted)
    assert said == first
    assert "The sensor lags" in doubts_of(doubted)[0] if first else not doubts_of(doubted)
    assert "the sensor lags" in str(doubted.warnings)


def test_a_stated_accuracy_is_named_with_its_part_of_both_bounds(result):
    share = Share(
        "impact_pressure_zero_pa", Estimate("zero", 102.0, 9.99), 2.44 * KNOT, 0.76 * KNOT
    )
    text = _terminal(replace(result, shares=(share,)), details=True)
    assert (
        "impact_pressure_zero_pa (estimated +102 ± 9.99) contributes ±2.44 kt to the curve" in text
    )
    assert "±0.76 kt to the wind" in text


@pytest.mark.parametrize(
    ("header", "origin"), [({}, "measured log"), ({"case": {}}, "simulated log")]
)
def test_a_page_says_whether_its_log_was_measured(log, result, header, origin):
    section = log_section("a.csv", replace(log, header=header), result)
    assert f"<p>From a {origin}</p>" in log_page("A log", [section])
    assert f"<p>From {origin}s</p>" in log_page("Two logs", [section, section])


def test_the_usual_accuracies_are_printed_with_the_answer_on_the_page_and_in_json(log, result):
    usual = USUAL_ACCURACIES
    found = calibrate(replace(log, header={}))
    tree = calibration_tree("", {found.model: found})
    for text in (_terminal(found), html_of(tree.nodes), found._repr_html_()):
        for part in (
            f"temperature ±{usual['temperature_k']:g} K (usual)",
            f"static pressure ±{usual['static_pressure_pa']:g} Pa (usual)",
            f"GPS velocity ±{usual['velocity_mps']:g} m/s (usual)",
        ):
            assert part in text
    document = calibration_json(found)
    stated = {"name": "temperature_k", "two_sigma": usual["temperature_k"], "source": "usual"}
    assert stated in document["assumptions"]
    assert document["impact_pressure_zero_pa"] is None
    # A log that states exact sensors is said to have no constant error.
    said = (
        "no constant error of temperature, recovery factor, static pressure, GPS velocity, total source "
        "(stated by the log)"
    )
    assert said in _terminal(result)


def test_a_zero_offset_in_the_correction_is_said_with_its_bound(log):
    options = CalibrationOptions(model="bias", accuracies={"impact_pressure_zero_pa": 400.0})
    result = calibrate(replace(log, impact_pressure=log.impact_pressure + 80.0), options)
    zero = result.impact_pressure_zero
    printed = _terminal(result)
    assert f"includes a sensor zero of −{-zero.value:.0f} ± {zero.two_sigma:.0f} Pa" in printed
    assert "a constant part of Δp looks the same" in printed
    assert calibration_json(result)["impact_pressure_zero_pa"]["value"] == zero.value


@pytest.mark.parametrize(
    ("channels", "sensor", "share"),
    [
        (("velocity_north", "velocity_east"), "GPS velocity", 0.01),
        (("static_pressure",), "static pressure", 0.005),
    ],
)
def test_a_factor_that_no_log_shows_is_told_with_what_it_moves(channels, sensor, share):
    """The log with the factor raises no finding; its curve is off by what the answer says."""
    log = trajectories.fly(trajectories.circles(2), 2, 2, trajectories.CALM)
    log = replace(log, header={"accuracy": USUAL_ACCURACIES})
    spoiled = replace(log, **{name: 1.01 * getattr(log, name) for name in channels})
    sound, off = (calibrate(each) for each in (log, spoiled))
    assert [each.words for each in findings_of(off)] == [each.words for each in findings_of(sound)]
    moved = off.curve.correction - sound.curve.correction
    np.testing.assert_allclose(
        moved, share * (sound.curve.indicated_airspeed + sound.curve.correction), rtol=0.1
    )
    (told,) = re.findall(rf"1 % on the {sensor}[^,]*? by ([\d.]+) kt", _terminal(sound))
    assert float(told) == pytest.approx(100.0 * share * 1.3, abs=0.05)
