"""The report of a reconciliation: every verdict is in words, with units, and the page stands alone."""

import re
from dataclasses import replace
from html import unescape
from io import StringIO

import numpy as np
import pytest
from matplotlib.figure import Figure
from rich.console import Console

from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.residuals import UNITS as RESIDUAL_UNITS
from pitotbench.records.calibration import Estimate
from pitotbench.records.forecast import BriefedLeg
from pitotbench.records.gap import (
    Account,
    CalibrationChange,
    Closing,
    Coefficient,
    Feature,
    FlownAgain,
    FormulaTerm,
    FoundFormula,
    GapMap,
    History,
    Step,
    TellingChannel,
    Tolerance,
    Trace,
)
from pitotbench.records.log import InputFile, Provenance
from pitotbench.records.verdict import (
    Candidate,
    Check,
    Closure,
    Detectable,
    FreeSize,
    Gap,
    JoinedFlight,
    Located,
    OwnSize,
    Verdict,
)
from pitotbench.show.gap_page import telling_panels, trace_marks, waterfall_panels
from pitotbench.show.gap_words import (
    calibration_words,
    evidence_words,
    features_limit,
    part_words,
    sentences,
)
from pitotbench.show.renderers import print_tree
from pitotbench.show.style import Panel, drawing, stacked
from pitotbench.show.tree import SOURCES, Heading
from pitotbench.show.verdict import account_json, candidate_columns
from pitotbench.show.verdict_tree import account_page, account_tree, reconciliation_record
from pitotbench.show.words import CHANNELS, heading, name_and_unit, size_words, words
from pitotbench.units import SYMBOLS

TIME = np.arange(200) / 2.0
EVERY = np.full(len(TIME), True)
POD = Candidate("belly_pod", (Estimate("drag_area_m2", 0.12, 0.01),), 50.0, 0.91)
GEAR = Candidate("gear_not_up", (Estimate("extension", 0.26, 0.02),), 49.9)
NAMED = Verdict(
    kind="named",
    gaps=(Gap("drag", 0.91, (POD,), True, False, 0.99, 0.98),),
    candidates=(POD, GEAR),
    located=(
        Located("specific_force_x", "", "airspeed", -68.2),
        Located("temperature", "level", "", 9.0),
    ),
    checks=(
        Check("clock", "passed", "rows every 0.02 s"),
        Check("saturation", "failed", "stands at 900 Pa"),
    ),
    closure=Closure(2000.0, 1010.0, 1000.0),
    smallest_detectable=(Detectable("pitot_lag", "lag_s", 0.08),),
    advice=("to sharpen belly_pod: level flight (four_leg)",),
    closure_holdout=Closure(1900.0, 1045.0, 1000.0),
)


def with_gap(
    *causes: Candidate, part: str = "drag", probability: float = 0.91, part_named: bool = False
) -> Verdict:
    """A verdict of one gap, with the causes of the set that holds it."""
    gap = Gap(part, probability, causes, False, part_named, 0.99, 0.98)
    return replace(NAMED, kind="one_of", gaps=(gap,), candidates=causes)


def flown() -> FlownAgain:
    history = History("pitch", "°", TIME, np.sin(TIME), np.sin(TIME) + 1.0, np.sin(TIME))
    feature = Feature("leg 150 kt 000°", "manifold pressure", "inHg", 33.1, 30.2, 33.0, 0.2, 4)
    return FlownAgain((feature,), (Tolerance("pitch", "°", 0.6, 0.25, 0.97, 0.98),), (history,))


def account(verdict: Verdict = NAMED) -> Account:
    before = np.array([[-68.2, 3.0], [1.0, np.nan]])
    return Account(
        log="flight.csv",
        aircraft="navajo",
        holdout="other.csv",
        verdict=verdict,
        gap_map=GapMap(
            ("specific_force_x", "temperature"),
            ("over airspeed", "level"),
            before,
            before / 20.0,
            4.3,
        ),
        waterfall=tuple(Step(each.name, 1010.0) for each in verdict.effects),
        traces=(Trace("specific_force_x", "m/s²", TIME, np.cos(TIME), np.cos(TIME), EVERY),),
        patch='[[effects]]\nname = "belly_pod"\n',
        entries=tuple((each.name, {"drag_area_m2": 0.12}) for each in verdict.effects),
        flown=flown(),
        null_flights=8,
    )


def test_the_answer_is_in_sentences_and_plain_data():
    text = " ".join(sentences(account()))
    assert text.startswith("It is belly pod (drag area 0.12 ± 0.01 m²; 91 %); ± is 2σ.")
    assert "specific force x over airspeed (-68σ)" in " ".join(evidence_words(account()))
    assert "closes 99 % of the explainable gap of this log, and 95 % of that of other.csv" in text
    assert "no significant gap remains" in text
    assert any(
        "before you believe" in text for text in sentences(replace(account(), null_flights=0))
    )
    # An effect that cannot be distinguished is named with its size.
    text = sentences(account(with_gap(POD, GEAR)))[0]
    assert "one of these" in text
    assert "or, less probably, gear not up (extension 0.26 ± 0.02; 99 %)" in text
    document = account_json(account())
    (gap,) = document["gaps"]
    assert (gap["part"], gap["named"], gap["closes_held_out"]) == ("drag", True, 0.98)
    assert gap["causes"][0]["parameters"] == [
        {"name": "drag_area_m2", "value": 0.12, "two_sigma": 0.01, "unit": "m²"}
    ]
    assert document["patch"] == [{"name": "belly_pod", "parameters": {"drag_area_m2": 0.12}}]
    assert document["flown_again"]["within_tolerance"][0]["after"] == 0.97
    assert document["closure_holdout"] == pytest.approx(0.95)


def doubted(**probabilities: float) -> Verdict:
    """A verdict of a pod with a probability, and of one further cause."""
    pod, rival = probabilities
    return with_gap(
        replace(POD, probability=probabilities[pod]),
        replace(GEAR, name=rival, probability=probabilities[rival]),
    )


def test_what_a_set_leaves_for_causes_of_another_form_is_told():
    told = sentences(account(doubted(belly_pod=0.7, gear_not_up=0.05)))[0]
    assert "With 25 % it is a cause that the table does not hold" in told
    assert "table does not hold" not in sentences(account())[0]
    assert (
        "table does not hold" not in sentences(account(doubted(belly_pod=0.5, turn_drag=0.45)))[0]
    )


def test_a_doubted_name_stands_without_a_cause_that_is_hardly_possible(capsys):
    shown = account(doubted(belly_pod=0.8, gear_not_up=0.01))
    print_tree(account_tree(shown), Console(width=200), depth=SOURCES)
    text = capsys.readouterr().out
    assert text.startswith("a probable cause\nIt is probably belly pod")
    assert "gear not up" not in text[: text.index("where the gap is")]
    assert "With 19 % it is a cause that the table does not hold in this form" in text


def test_what_speaks_against_a_probable_cause_is_told_in_place_of_the_rest():
    against = "the sizes of the other flights close only 50 % of the gap of b.csv"
    told = sentences(
        account(replace(doubted(belly_pod=0.5, gear_not_up=0.01), remains=True, doubts=(against,)))
    )
    assert f"What speaks against it: {against}." in told
    assert not any("Something remains" in line for line in told)


def test_the_largest_place_that_no_cause_explains_stands_in_the_first_paragraph():
    place = Located("roll_acceleration", "turn", "", -26.0)
    remaining = sentences(account(replace(NAMED, remains=True, located=(place,))))
    words = "no effect of the table explains{}, most of it in roll acceleration in turn (-26σ)."
    assert any(line.endswith(words.format("")) for line in remaining)
    unknown = replace(NAMED, kind="unknown", gaps=(), candidates=(), located=(place,))
    assert sentences(account(unknown))[0].endswith(words.format(" it"))


@pytest.mark.parametrize(("right", "is_yawing"), [(-0.066, True), (0.066, False), (-0.004, False)])
def test_opposite_signs_on_the_two_sides_are_told_as_one_yawing_moment(right, is_yawing):
    sizes = (
        Estimate("left_fraction", 0.065, 0.01),
        Estimate("right_fraction", right, 0.01),
    )
    propellers = Candidate("propeller_efficiency", sizes, 50.0, 0.91)
    part = "engine or propeller, a side"
    gap = Gap(part, 0.91, (propellers,), True, False, 0.99, 0.98)
    told = sentences(account(replace(NAMED, gaps=(gap,), candidates=(propellers,))))[0]
    assert ("together a yawing moment" in told) is is_yawing


def test_the_warnings_of_the_logs_stand_below_the_answer(capsys):
    found = replace(account(), warnings=("other.csv: column 'heading_deg': wrong sign?",))
    print_tree(account_tree(found), Console(width=200), depth=SOURCES)
    text, page = capsys.readouterr().out, unescape(account_page(found))
    assert (
        text.index("closes 99 %")
        < text.index("warning: other.csv: column 'heading")
        < text.index("where the")
    )
    assert (
        page.index("closes 99 %")
        < page.index("column 'heading_deg'")
        < page.index("Where the gap is")
    )
    assert account_json(found)["warnings"] == list(found.warnings)


@pytest.mark.parametrize(
    ("kind", "said"), [("unknown", "no effect of the table"), ("no_gap", "agree")]
)
def test_a_verdict_without_a_patch_offers_none(kind, said):
    found = account(replace(NAMED, kind=kind, gaps=(), closure_holdout=None))
    assert said in sentences(found)[0]
    assert "The patch" not in account_page(found)


def test_a_formula_is_told_with_its_unit_its_rivals_and_its_patch():
    size = Estimate("bank_squared_deg", 2.04, 0.3)
    rival = "Δθ (pitch) with sin φ"
    term = FormulaTerm("pitch_formula", size, "pitch", "Δθ", "deg", "sin²φ", 40.0, (rival,))
    told = Candidate("pitch_formula", (size,), 40.0)
    gap = Gap("", 0.97, (told,), False, False, 0.99, 0.98)
    verdict = replace(NAMED, kind="unknown", gaps=(gap,))
    found = replace(
        account(verdict),
        formula=FoundFormula((term,)),
        patch='name = "pitch_formula"',
        entries=(("pitch_formula", {"bank_squared_deg": 2.04}),),
    )
    text = " ".join(sentences(found))
    assert "The gap follows a formula: pitch: Δθ = (2.04 ± 0.3)° sin²φ; ± is 2σ." in text
    assert f"In the place of Δθ with sin²φ, the log is explained as well by {rival}." in text
    assert "closes 99 % of the explainable gap of this log, and 95 % of that of other.csv" in text
    page = account_page(found)
    assert "sin²φ" in page
    assert "pitch_formula" in page
    (told,) = account_json(found)["gaps"]
    assert (told["part"], told["causes"][0]["name"]) == (None, "pitch_formula")


def test_gaps_beside_one_another_are_numbered_and_an_unknown_far_from_its_prior_is_told():
    second = Gap("pitot line", 0.9, (LAG,), True, True, 0.2, 0.2)
    vane = FreeSize("angle_of_attack scale", 0.151, 0.01, 0.02)
    verdict = replace(NAMED, gaps=(*NAMED.gaps, second), free=(vane,))
    first, *others = sentences(account(verdict))
    assert first.startswith("There are 2 gaps beside one another: 1, belly pod (drag area 0.12")
    assert "2, the pitot line (90 %): pitot lag" in first
    assert any("angle of attack scale comes out at +0.151 ± 0.01" in line for line in others)
    assert account_json(account(verdict))["free"][0]["prior"] == 0.02


def test_the_page_stands_alone_and_holds_every_part():
    page = account_page(account())
    assert not re.search(r'(src|href)="(?!#|data:)', page)
    parts = (
        "σ",
        "thrust less drag [g]",
        "[min]",
        "inHg",
        "rows every 0.02 s",
        "stands at 900 Pa",
        "lag 0.08 s",
    )
    assert [
        part for part in (*parts, "<td>25</td><td>97</td><td>98</td>") if part not in page
    ] == []
    assert ">nan<" not in page


@pytest.mark.parametrize(
    ("size", "said"),
    [
        (("latency_s", 0.3, 0.02), "latency 0.3 ± 0.02 s"),
        (("drag_area_m2", 0.1), "drag area 0.1 m²"),
        (("ceiling_pa", 2704.0, 1.0), "ceiling 2704 ± 1 Pa"),
        (("offset_pa", -577.0, 704.0), "offset -577 ± 700 Pa"),
        (("extension", 0.26), "extension 0.26"),
        (("shift_pa_per_k", 6.0, 1.0), "shift 6 ± 1 Pa per K"),
        (("north_mps_per_min", 0.15), "north 0.15 m/s per min"),
        (("loss_per_rad2", 1.0), "loss 1 per rad²"),
    ],
)
def test_sizes_carry_their_unit(size, said):
    assert size_words(*size) == said


def test_every_size_of_an_effect_has_words_without_a_suffix_and_initials_are_capitals():
    for effect in EFFECTS.values():
        for parameter in effect.parameters:
            noun, _ = name_and_unit(parameter.name)
            assert not set(SYMBOLS) & set(noun.split()[1:]), parameter.name
            assert " per" not in noun, parameter.name
    assert words("to sharpen gps_latency: fly") == "to sharpen GPS latency: fly"
    assert (heading("gps_latency"), heading("belly_pod")) == ("GPS latency", "Belly pod")


@pytest.mark.filterwarnings("error")
def test_a_step_above_the_measured_gap_leaves_room_for_the_names():
    """Sizes that cancel one another raise it: the layout gave up there, and cut the names."""
    steps = (Step("control_moments", 60_000.0), Step("pitch_stiffness", 1010.0))
    (panel,) = waterfall_panels(replace(account(), waterfall=steps))
    assert "with control moments" in panel.drawing


def telling(channel: str = "specific_force_x", mass: float | None = 2500.0) -> TellingChannel:
    n = len(TIME)
    gap = np.full(n, -0.2)
    held = None if mass is None else np.full(n, mass)
    speed = np.linspace(50.0, 80.0, n)
    return TellingChannel(
        channel, "m/s²", TIME, gap, gap * 0.0, 0.01, 4.0, "airspeed", speed, TIME * 50.0, TIME, TIME > 75.0, held,
        EVERY,
    )  # fmt: skip


def test_the_first_picture_is_in_the_units_of_the_field():
    # 0.2 m/s² of 2,500 kg are 500 N: 112.4 lb.
    drawn = telling_panels(telling())
    assert len(drawn) == 3
    assert "measured − simulated [lb]" in drawn[0].drawing
    assert "true airspeed [kt]" in drawn[1].drawing
    assert "−112" in drawn[0].drawing or "−100" in drawn[0].drawing
    assert "[g]" in telling_panels(telling(mass=None))[0].drawing


def test_instants_that_were_not_used_are_shaded_and_named():
    late = TIME > 80.0
    gap = np.where(late, 1e6, -0.2)
    trace = Trace("specific_force_x", "m/s²", TIME, gap, 0.1 * np.cos(TIME), ~late)
    with stacked([drawing(*trace_marks(trace))], (4.6, 2.9), 3) as figure:
        (axes,) = figure.axes
        assert axes.get_ylim()[1] < 1.0  # the axis is that of the instants used
        assert "not used" in axes.get_legend_handles_labels()[1]
        (shade,) = axes.patches
        assert shade.get_x() == pytest.approx(80.25 / 60.0)
    whole, spoilt = telling(), replace(telling(), gap=gap, used=~late)
    assert "not used" not in telling_panels(whole)[0].drawing
    over_time, over_speed, _ = telling_panels(spoilt)
    assert "not used" in over_time.drawing
    assert "1000000" not in over_speed.drawing.replace(",", "")


def test_every_channel_and_variable_has_a_unit_of_the_field(monkeypatch):
    """Each is drawn, and not written as a picture, which takes most of the time."""
    assert set(CHANNELS) == set(RESIDUAL_UNITS)

    def drawn(title, draw, *rest, **more):
        axes = Figure().subplots()
        draw(axes)
        return Panel(title, axes.get_ylabel())

    monkeypatch.setattr("pitotbench.show.gap_page.panel", drawn)
    for channel in CHANNELS:
        over_time = telling_panels(telling(channel))[0]
        assert over_time.title[0].isupper()
        assert over_time.drawing.startswith("measured − simulated [")


def test_the_page_begins_with_the_answer_and_its_picture():
    found = replace(
        account(),
        telling=telling(),
        calibration=CalibrationChange(np.array([50.0]), np.array([0.5])),
    )
    page = account_page(found)
    first = page[: page.index("What is added")]
    assert "up to 1.0 kt too high (at 97 KIAS" in first
    assert first.count("<svg") == 3
    assert "σ over" not in first


@pytest.mark.parametrize(
    ("change", "said"),
    [(0.0, "stays the same"), (-1.0, "1.9 kt too low"), (0.3, "0.6 kt too high")],
)
def test_what_a_calibration_suffers_is_said_with_its_sign(change, said):
    assert said in calibration_words(
        CalibrationChange(np.array([50.0, 60.0]), np.array([0.0, change]))
    )


def joined() -> Account:
    def flight(log: str, apart: float, left_out: float) -> JoinedFlight:
        own = OwnSize("belly_pod", Estimate("drag_area_m2", 0.11, 0.02), apart)
        closure, held = (
            Closure(2000.0, 1010.0, 1000.0),
            Closure(2000.0, 2000.0 - 1000.0 * left_out, 1000.0),
        )
        return JoinedFlight(
            log,
            "circle",
            8.1,
            "one_of",
            (("belly_pod", "turn_drag"),),
            80.0,
            closure,
            held,
            (own,),
            8,
        )

    return replace(account(), flights=(flight("a.csv", 1.4, 0.97), flight("b.csv", 6.3, 0.31)))


def test_several_flights_are_told_on_the_page_and_in_json():
    page, document = account_page(joined()), account_json(joined())
    for part in ("a.csv", "b.csv", "belly pod or turn drag", "6.3", "0.31"):
        assert part in page, part
    # Its steps are of one flight, and the gap is that of all.
    assert "effect by effect" in account_page(account())
    assert "The flights" not in account_page(account())
    assert "effect by effect" not in page
    assert [flight["log"] for flight in document["flights"]] == ["a.csv", "b.csv"]
    assert document["flights"][1]["closure_left_out"] == pytest.approx(0.31)
    assert document["flights"][1]["own_sizes"][0]["apart"] == pytest.approx(6.3)
    assert document["flights"][0]["causes_alone"] == [["belly_pod", "turn_drag"]]


def test_a_notebook_shows_the_sentences_the_probabilities_and_the_sizes():
    found = replace(joined(), verdict=replace(NAMED, probabilities={"belly_pod": 0.91}))
    assert "It is belly pod" in repr(found)
    assert "b.csv" in found._repr_html_()
    frame = found.to_frame()
    row = frame[frame["named"]].iloc[0]
    assert (row["effect"], row["parameter"], row["value"]) == ("belly_pod", "drag_area_m2", 0.12)
    (bar,) = found.plot().axes[0].patches
    assert bar.get_width() == pytest.approx(0.91)


LAG = Candidate("pitot_lag", (Estimate("lag_s", 0.33, 0.06),), 30.0, 0.74)
WATER = Candidate(
    "water_in_line", (Estimate("lag_s", 0.31, 0.06), Estimate("column_m", 0.02, 0.01)), 29.0
)
WATER = replace(WATER, probability=0.2)
STATIC = Candidate("static_lag", (Estimate("lag_s", 0.5, 0.1),), 20.0, 0.03)
PARTED = with_gap(LAG, WATER, STATIC, part="pitot line", probability=0.97, part_named=True)


def test_the_part_is_told_first_then_its_causes_and_last_those_of_other_parts(capsys):
    found = account(PARTED)
    assert sentences(found)[0] == (
        "It is the pitot line (97 %): pitot lag (lag 0.33 ± 0.06 s; 74 %) or water in line (lag "
        "0.31 ± 0.06 s; column 0.02 ± 0.01 m; 20 %); less probably, it is static lag (lag 0.5 ± "
        "0.1 s; 3 %); ± is 2σ."
    )
    print_tree(account_tree(found), Console(width=200), depth=SOURCES)
    assert capsys.readouterr().out.startswith(
        "pitot line: one of these causes\nIt is the pitot line (97 %)"
    )
    assert "It is the pitot line (97 %)" in account_page(found)
    late, drifts = (replace(LAG, name=name) for name in ("gps_latency", "clock_drift"))
    gps = with_gap(
        late, drifts, part="GPS receiver and its clock", probability=0.92, part_named=True
    )
    assert "GPS receiver and its clock: one of these causes" in account_page(account(gps))
    (gap,) = account_json(found)["gaps"]
    assert (gap["part"], gap["probability"]) == ("pitot line", 0.97)
    assert [each["name"] for each in gap["causes"]] == ["pitot_lag", "water_in_line", "static_lag"]


def test_a_part_that_shares_a_model_is_told():
    assert (
        part_words("pitot head", ["total_pressure_loss"])
        == "the pitot head or the impact transducer"
    )


def test_title_and_table_agree_on_what_is_named():
    assert "the most probable" in account_page(account(PARTED))
    doubted, named = (
        [candidate_columns(v)[-1].value(each) for each in v.candidates] for v in (PARTED, NAMED)
    )
    assert doubted == ["the most probable", *["cannot be distinguished"] * 2]
    assert named == ["named", ""]


def test_the_remaining_gap_is_the_first_map_and_the_patch_with_its_commands_stands_under_the_answer():
    page = account_page(account())
    assert page.index("The remaining gap [σ]") < page.index("The gap before the patch [σ]")
    assert page.index("It is belly pod") < page.index("The patch") < page.index("Where the gap is")
    assert "pitotbench fly case.toml" in page
    assert "--apply NAME" in page
    assert "--apply NAME" not in account_page(account(PARTED))  # nothing of the aircraft


def numbers(*sigmas: float) -> FlownAgain:
    """A card flown again with characteristic numbers that differ by some σ, and seventy that do
    not.
    """
    features = [
        Feature("leg", f"number {i}", "kt", s, 0.0, 0.0, 1.0, 4)
        for i, s in enumerate([*sigmas] + [1.0] * 70)
    ]
    return FlownAgain(
        tuple(features), (Tolerance("indicated airspeed", "kt", 1.2, 0.87, 0.89, 0.95),), ()
    )


def test_what_differs_by_chance_is_no_gap_and_what_differs_by_more_stands_beside_the_sentence_of_none():
    # Student's t of four degrees of freedom exceeds 7 once in 450 numbers: one card of six has one
    # among 77.
    assert 8.0 < features_limit(numbers(7.0).features) < 11.0
    chance, more = (replace(account(), flown=numbers(s)) for s in (7.0, 20.0))
    assert "With that in the model, no significant gap remains." in sentences(chance)
    assert "differ by more than chance, before" not in account_page(chance)
    assert "(1 of 71)" in account_page(more)
    assert "indicated airspeed is within its tolerance less often" in account_page(chance)
    assert "less often" not in account_page(account())


def test_the_record_is_in_the_order_of_a_qualification_test():
    digest = "0123456789abcdef" * 4
    made = Provenance(
        (InputFile("aircraft", "navajo.xml", digest),), (), {"pitotbench": "0.1.0"}, "2026-01-01"
    )
    unsure = replace(NAMED, doubts=("it closes only 0.7",), remains=True, closure_holdout=None)
    page, doubtful = (reconciliation_record(account(each), made) for each in (NAMED, unsure))
    headings = [
        "Objective and inputs",
        "Settings",
        "Conditions",
        "Tolerances",
        "Results",
        "Statement",
        "Checks",
    ]
    assert re.findall("<h2>(.*?)</h2>", page) == headings
    assert digest in page
    assert "pitotbench 0.1.0" in page
    assert "belly pod (drag area 0.12 ± 0.01 m²" in page
    row = "<tr><td[^>]*>(.*?)</td><td[^>]*>(passed|failed|skipped)</td>"
    speaks, remains = "nothing speaks against the answer", "nothing remains beside it"
    explained = "a log that was not used is explained"
    passed = ("clock", speaks, remains, explained, "flown again within the tolerances")
    assert dict(re.findall(row, page)) == dict.fromkeys(passed, "passed") | {"saturation": "failed"}
    rows = dict(re.findall(row, doubtful))
    assert (rows[speaks], rows[remains], rows[explained]) == ("failed", "failed", "skipped")


SLOPE = Candidate("lift_slope", (Estimate("change", -0.2, 0.02),), 90.0, 0.91)
LATE = Candidate("gps_latency", (Estimate("latency_s", 0.4, 0.04),), 30.0, 0.91)


def closed(*gaps: Candidate, told: tuple[Candidate, ...] = (), kind: str = "no_gap") -> Account:
    """An account whose loop was closed."""
    parts = [Gap("drag", 0.9, (each, GEAR), False, True, 0.6, 0.5) for each in (*gaps, *told)]
    verdict = replace(NAMED, kind=kind, gaps=tuple(parts[len(gaps) :]))
    slope = Coefficient("lift_slope", "change", 5.0, Estimate("per rad", 4.0, 0.1))
    patched, beside = tuple(parts[: len(gaps)]), tuple(parts[len(gaps) :])
    shares = (0.5, 0.62) if gaps else ()
    closing = Closing(
        "navajo+fixed", shares, patched, beside, (slope,), verdict, closure_holdout=0.58
    )
    return replace(account(), closing=closing)


def test_a_closed_loop_is_one_table_in_text_page_and_data():
    made = closed(SLOPE, POD, told=(LATE,), kind="named")
    console = Console(record=True, width=200, file=StringIO())
    print_tree(account_tree(made), console, depth=SOURCES)
    page, text = account_page(made), " ".join(console.export_text().split())
    for each in (page, text):
        assert "closes 62 % of the gap held out, and 58 % of that of the held-out log" in each
        assert "4 ± 0.1 per rad; change −0.2 ± 0.02" in each
        assert "Judged again with it: It is" in each
        assert "gear not up" in each
    rows = account_json(made)["closed"]["table"]
    assert [row["patched"] for row in rows] == [True, True, False]
    assert rows[0]["model"] == 5.0
    assert rows[0]["measured"] == {"name": "per rad", "value": 4.0, "two_sigma": 0.1}
    assert rows[1]["model"] is None
    assert rows[2]["causes"][0]["name"] == "gps_latency"
    assert account_json(made)["closed"]["left"]["verdict"] == "named"


def test_a_loop_that_patched_nothing_says_so():
    page = account_page(closed(told=(LATE,), kind="named"))
    assert "navajo+fixed is not written" in page
    assert account_json(closed())["closed"]["aircraft"] is None
    assert account_json(account())["closed"] is None
    assert "The loop closed" not in account_page(account())


def test_the_card_of_the_next_flight_is_folded_away():
    """Its rows would stand before what is added to the model."""
    leg = BriefedLeg("leg 160 kt", 30.0, 0.0, 0.0, 82.3)
    nodes = account_tree(replace(account(), following="four_leg", legs=(leg,)))
    (card,) = [n for n in nodes if isinstance(n, Heading) and n.text.startswith("The card for")]
    assert card.depth == SOURCES
