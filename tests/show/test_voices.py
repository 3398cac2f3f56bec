"""One answer in every voice: the numbers that terminal, -v, page, record, notebook and panel write
are those of the document, in knots and in the reader's units, and no voice lacks a doubt.
"""

import ast
import re

import numpy as np
import pandas as pd
import pytest
from scipy.interpolate import CubicSpline
from tests.show.test_gap_report import account
from tests.show.voices import BENCH_UNIT, METRIC, contradictions, left_in_knots, voices_of

from pitotbench.bench.questions import inspect
from pitotbench.calibration.hand_card import reduce_card
from pitotbench.logbook.points_table import read_points
from pitotbench.records.comparison import ChannelChange, ModelComparison, TermChange
from pitotbench.records.forecast import Forecast, Plan
from pitotbench.records.linear_model import LinearModel, Mode
from pitotbench.records.performance import Performance, PerformanceFigure
from pitotbench.show.calibration import short_answer_of
from pitotbench.show.calibration_json import calibration_json
from pitotbench.show.calibration_tree import calibration_tree
from pitotbench.show.campaign import campaign_tree
from pitotbench.show.columns import frame_rows
from pitotbench.show.comparison import comparison_json, comparison_tree
from pitotbench.show.curve_difference import compare_curves, difference_json, difference_tree
from pitotbench.show.curve_rows import points_json
from pitotbench.show.inspection import (
    inspection_json,
    inspection_tree,
    performance_json,
    performance_tree,
)
from pitotbench.show.legs import card_json, card_tree
from pitotbench.show.linear_model import linear_json, linear_tree
from pitotbench.show.plan import plan_json, plan_tree
from pitotbench.show.reader_units import BENCH, QUOTED
from pitotbench.show.tree import ANSWER, NUMBERS, SOURCES, Doubt, Heading, Sentence
from pitotbench.show.verdict import account_json
from pitotbench.show.verdict_tree import account_tree
from pitotbench.units import KNOT, POUND, SUFFIXES
from pitotlab.house import PRODUCT

CARD = """point,indicated_airspeed_kt,pressure_altitude_ft,air_temperature_degc,ground_speed_kt,track_deg
1,90,3000,9,100,0
1,90,3000,9,87,120
1,90,3000,9,95,240
2,120,3000,9,132,0
2,120,3000,9,119,120
2,120,3000,9,127,240
"""


def calibration(result, tmp_path):
    document = calibration_json(result) | {"fixed_speed": points_json(result.points)}
    return calibration_tree("", {result.model: result}).nodes, document, beside(result)


def beside(result):
    """What a calibration writes that follows from numbers of its document: winds by speed, heights
    in feet, points less the curve.
    """
    winds = [np.hypot(w.north.value, w.east.value) / KNOT for w in result.winds]
    curve = result.curve
    known = CubicSpline(curve.indicated_airspeed, curve.correction)
    off = [float(p.correction - known(p.indicated_airspeed)) / KNOT for p in result.points]
    rms = float(np.sqrt(np.mean(curve.two_sigma**2))) / KNOT
    return [*winds, *off, rms, result.reference_pressure]


def inspection(log, tmp_path):
    found = inspect(log)
    ends = [end for c in found.channels for end in (c.low, c.high) if end is not None]
    shown = [end / unit.factor - unit.offset for end in ends for unit in SUFFIXES.values()]
    minutes = sum(end - start for start, end in found.flights) / 60.0
    return inspection_tree(found), inspection_json(found), [*shown, minutes]


def plan(_, tmp_path):
    speeds, bounds = np.array([100.0, 160.0]) * KNOT, np.array([0.3, 0.2]) * KNOT
    forecasts = tuple(
        Forecast(
            n, {}, 12.25, 15.5, 0.5, (9e3, 8e3), speeds, bounds, bounds, 0.01, np.zeros((2, 2))
        )
        for n in ("step_both_ways", "figure_eight")
    )
    found = Plan("it", forecasts, {}, *forecasts, None, 0, want=0.2 * KNOT, minutes=20.0)
    times = found.best.times_for(found.want) * found.best.minutes
    return plan_tree(found), plan_json(found), [times, found.best.within(20.0) / KNOT]


def campaign(result, tmp_path):
    row = {"model": "inverse+", "das": "20/1", "curve_coverage": 0.61, "minutes": 8.25}
    row |= {"samples": 512, "curve_rms_error_kt": 0.123, "wind_error_kt": 0.456}
    table = pd.DataFrame(
        [
            row | {"maneuver": "step_decrease", "residual_two_sigma_kt": 0.5, "two_sigma_kt": 0.41},
            row | {"maneuver": "four_leg", "residual_two_sigma_kt": 0.91, "two_sigma_kt": 0.13},
        ]
    )
    answers = [short_answer_of(result, f"{name} 20/1") for name in ("step_decrease", "four_leg")]
    document = [frame_rows(table), calibration_json(result)]
    return campaign_tree(table, answers, ["circle: it stalls"]), document, []


def verdict(_, tmp_path):
    found = account()
    # The document holds neither the sizes of what is not named nor the features of the card.
    sizes = [n for c in found.verdict.candidates for s in c.sizes for n in (s.value, s.two_sigma)]
    features = [
        number
        for f in found.flown.features
        for number in (
            *(f.measured, f.simulated, f.patched),
            *((f.measured - each) / f.deviation for each in (f.simulated, f.patched)),
        )
    ]
    tolerance = 1.5  # ° of pitch, by the rule
    return account_tree(found), account_json(found), [*sizes, *features, tolerance]


def curves(result, tmp_path):
    found = compare_curves("one", result.curve, "other", result.curve)
    document = [difference_json(found), calibration_json(result)]
    return difference_tree(found, result.curve, result.curve), document, []


def airplanes(_, tmp_path):
    change = ChannelChange("drag", "level", "lb", 12.5, 31.25, 0.043, 0.0012)
    term = TermChange("CD0", "aerodynamics", "", 0.024, 0.026, (change,))
    found = ModelComparison(
        "a", "b", "diagnostic", np.arange(2.0), {}, (change,), (change,), (term,)
    )
    return comparison_tree(found), comparison_json(found), [100.0 * (0.026 / 0.024 - 1.0)]


def performance(_, tmp_path):
    figures = (PerformanceFigure("stall speed", "flaps up", 61.7, "KCAS", 60.0),)
    found = Performance("navajo", 2900.0, figures, (("climb", "no engine"),))
    return performance_tree(found), performance_json(found), [2900.0 / POUND]


def linear(_, tmp_path):
    found = LinearModel(
        aircraft="T37",
        mass=2900.0,
        height=2438.4,
        calibrated_airspeed=103.2,
        roll_acceleration=-0.1834,
        states={"Vt": "ft/s", "P": "rad/s"},
        inputs={"ThtlCmd": "norm"},
        trim=np.array([379.5, 0.0]),
        setting=np.array([0.75]),
        system_matrix=np.array([[-0.0432, 0.0], [0.0051, -3.8531]]),
        input_matrix=np.array([[10.85], [0.0]]),
        modes=(Mode("roll", -3.8531 + 0.0j), Mode("Dutch roll", 0.2877 + 1.9281j)),
    )
    return linear_tree(found), linear_json(found), []


def card(_, tmp_path):
    path = tmp_path / "legs.csv"
    path.write_text(CARD, encoding="utf-8")
    found = reduce_card(*read_points(path))
    return card_tree(found), card_json(found), []


KINDS = (
    inspection,
    calibration,
    plan,
    campaign,
    verdict,
    curves,
    airplanes,
    performance,
    linear,
    card,
)


@pytest.mark.parametrize("kind", KINDS, ids=[kind.__name__ for kind in KINDS])
def test_every_voice_says_the_numbers_and_the_doubts_of_the_document(kind, log, result, tmp_path):
    nodes, document, more = kind(log if kind is inspection else result, tmp_path)
    assert contradictions(nodes, document, more) == {}
    assert left_in_knots(nodes) == []


def test_a_number_of_another_fit_and_a_missing_doubt_are_found(result):
    """The comparison can fail."""
    nodes, document, more = calibration(result, None)
    wrong = [*nodes, Sentence("Add +7.77 ± 3.33 kt at 101 KIAS.")]
    found = contradictions(wrong, document, more)
    assert found["terminal, kt"] == ["+7.77", "3.33"]
    assert set(found) >= {f"{voice}, kt" for voice in voices_of(nodes, BENCH)}
    assert left_in_knots([Sentence("at  101 KIAS, of 7.5 kts and between 5and 6 kt/s")]) == []
    assert left_in_knots([Sentence("(3) x5 kt")]) == ["(3) x5 kt"]
    assert left_in_knots([Heading("wind of x5 kt", (Sentence(f"{QUOTED}5{QUOTED}kt"),))]) != []


def test_no_voice_leaves_out_a_doubt_wherever_it_stands():
    """A doubt in a part that a voice folds away or does not print."""
    for depth in (ANSWER, SOURCES, NUMBERS):
        nodes = [Heading("Evidence", (Doubt("it may be wrong"), Sentence("3.5 kt")), depth)]
        assert contradictions(nodes, 3.5) == {}


def sentences_of_the_product():
    """Each text of the product behind its place, with 1.5 for each value that is put into it."""
    for path in sorted(PRODUCT.rglob("*.py")):
        nodes = [*ast.walk(ast.parse(path.read_text(encoding="utf-8")))]
        filled = [n for n in nodes if isinstance(n, ast.JoinedStr)]
        inside = {id(each) for n in filled for each in ast.walk(n) if each is not n}
        texts = [(n, n.values) for n in filled]
        texts += [
            (n, [n]) for n in nodes if isinstance(n, ast.Constant) and isinstance(n.value, str)
        ]
        for node, parts in texts:
            if id(node) not in inside:
                told = (p.value if isinstance(p, ast.Constant) else "1.5" for p in parts)
                yield f"{path.name}:{node.lineno}: ", re.sub(r"\{[^}]*\}", "1.5", "".join(told))


def test_no_sentence_of_the_product_hides_its_units_from_the_reader():
    """Also those that no answer of a test says: a number and a unit that stand together in another
    way than the translation knows, and a number before it that is not translated with it.
    """
    half = re.compile(r"\d(?: or |[/–])[\d.]+ (km/h|m|°F|hPa)(?![\w/²])")
    found = [(place, text) for place, text in sentences_of_the_product() if BENCH_UNIT.search(text)]
    own = [place + METRIC.text(re.sub(rf"\S+{QUOTED}\w+", "", text)) for place, text in found]
    assert len(own) > 100
    assert [text for text in own if BENCH_UNIT.search(text) or half.search(text)] == []
