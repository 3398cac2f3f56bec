"""Effects that were put into a flight are found with their size and close a held-out log; else none
is named.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from pitotbench import BadInputError, Case, UnknownNameError, fly, read_case, sense
from pitotbench.bench.flown_card import card_of
from pitotbench.bench.workflow import NamedLog, judge_logs
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import AircraftEffect
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.equations import noise_of_log
from pitotbench.reconciliation.fitting import _at_single, fit_gaps
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.null_distribution import Measure, theoretical_distribution
from pitotbench.reconciliation.other_flights import hold_out
from pitotbench.reconciliation.patches import patch_of_effects
from pitotbench.reconciliation.regression import FittedHypothesis, FoundGap
from pitotbench.reconciliation.signatures import cause_of, residual_change, returns
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.reconciliation.verdict import _all_flights, _answer, judge, may_be_form
from pitotbench.records.case import EffectSpec
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import Verdict
from pitotbench.show.verdict import verdict_json
from pitotbench.units import INCH_OF_MERCURY

FEW = ("belly_pod", "inclined_pod", "power_deficit", "mass", "pitot_lag", "gps_latency")


@pytest.fixture(scope="module")
def laid_out():
    """A flight with a pod that the model lacks, laid out for a few hypotheses."""
    case = Case(
        maneuver="rapid_decel",
        truth_seed=21,
        effects=(EffectSpec("belly_pod", {"drag_area_m2": 0.12}),),
    )
    few = Catalog("effect", {name: EFFECTS[name] for name in FEW})
    return lay_out(
        sense(fly(case), "20/20"), aircraft_model("navajo"), AnalysisSetting(day_known=True), few
    )


@pytest.fixture(scope="module")
def pod(laid_out):
    """The same judged without null flights."""
    return judge(["flight"], [laid_out], [theoretical_distribution(laid_out)]).verdict


@pytest.mark.parametrize("stands_out", ["threshold", "cell_threshold", ""])
def test_an_answer_needs_a_cell_or_an_effect_beyond_those_of_null_flights(
    laid_out, pod, stands_out
):
    """The gap of the flight stays; what null flights show by chance is made as large as it."""
    null = replace(theoretical_distribution(laid_out), flights=8)
    large = dict.fromkeys({"threshold", "cell_threshold"} - {stands_out}, 1e6)
    verdict = judge(["flight"], [laid_out], [replace(null, **large)]).verdict
    told = (verdict.kind, [effect.name for effect in verdict.effects])
    assert told == ((pod.kind, [e.name for e in pod.effects]) if stands_out else ("no_gap", []))
    assert any("stands out" in note for note in verdict.notes) == (not stands_out)


@pytest.mark.parametrize(("threshold", "seen"), [(8.0, False), (0.1, True)])
def test_a_further_gap_is_seen_by_the_same_rule_as_the_first(laid_out, threshold, seen):
    """Beside a pod of 8σ and more, many small scores are no gap that anyone sees."""
    null = replace(theoretical_distribution(laid_out), flights=8)
    null = replace(null, threshold=threshold, cell_threshold=threshold)
    fitted = fit_gaps([laid_out], [null])
    assert "belly_pod" in [member.name for member in fitted.members]
    further = replace(fitted.left, log_bayes_factor=2.0 * THRESHOLDS.gap_bayes_factor)
    assert replace(fitted, left=further).shows_more == seen


def test_what_is_told_passes_the_one_map_and_can_be_seen(laid_out, pod):
    """Other gusts than those of the card, beside a pod."""
    gusts = Measure(-3.0, 0.1)
    null = replace(theoretical_distribution(laid_out), flights=8, gust_level=gusts)
    verdict = judge(["flight"], [laid_out], [null]).verdict
    told = {cause.name: cause.probability for gap in verdict.gaps for cause in gap.causes}
    assert "turbulence_level" in told
    for gap in verdict.gaps:
        assert sum(cause.probability for cause in gap.causes) <= gap.probability + 1e-9
        assert gap.probability <= THRESHOLDS.told_closed
    (unseen,) = [note for note in verdict.notes if note.startswith("cannot be seen")]
    assert not [name for name in told if name in unseen.split(": ")[1].split(", ")]


@pytest.mark.parametrize(("share", "named"), [(0.9989, True), (0.97, False)])
def test_a_name_is_told_by_the_probability_that_is_told(laid_out, share, named):
    fitted = fit_gaps([laid_out], [theoretical_distribution(laid_out)])
    forms = {"belly_pod": share, "mass": 0.9999 - share}
    gaps = tuple(replace(gap, forms=forms) for gap in fitted.gaps)
    shown, _ = _all_flights(["flight"], fitted)
    verdict = _answer(replace(fitted, gaps=gaps), shown, [])
    assert [gap.named for gap in verdict.gaps] == [named]
    assert verdict.kind == ("named" if named else "one_of")


def test_a_bent_throttle_pickup_moves_the_engines_of_the_force_meter(laid_out):
    """The meter runs the engines on the recorded throttles: a wrong one is a wrong pressure."""
    reference = laid_out.reference
    moved = residual_change(
        EFFECTS["throttle_pickup"], reference, EFFECTS["throttle_pickup"].typical()
    )
    for side in ("left", "right"):
        column = moved[:, reference.channel(f"manifold_pressure_{side}")]
        assert np.abs(column).max() > 0.1 * INCH_OF_MERCURY


def test_a_strong_sensor_effect_is_taken_out_before_the_others_are_computed(sensed):
    """Else the signatures of the others are those of a track that the effect bent."""

    def tracks(*effects: str):
        layout = lay_out(sensed(*effects, das="20/20"), None, AnalysisSetting(day_known=True))
        single = _at_single(layout, noise_of_log(layout))
        return (each.reference.clean["impact_pressure"] for each in (layout, single))

    true, same = tracks()
    assert np.array_equal(true, same)
    bent, mended = tracks("pitot_lag")
    assert np.std(mended - true) < 0.3 * np.std(bent - true)


def judged(log: FlightLog) -> Verdict:
    """The verdict of a log by its sensors alone."""
    return judge_logs([NamedLog("log", log)], "none")[1].verdict


def test_sensors_alone_without_an_effect_name_nothing(sensed) -> None:
    verdict = judged(sensed(das="20/20"))
    assert verdict.kind == "no_gap"
    assert verdict.effects == ()
    assert verdict.smallest_detectable


def test_gps_latency_is_named_by_the_sensors_alone(sensed) -> None:
    verdict = judged(sensed("gps_latency", das="20/20"))
    assert verdict.kind == "named"
    assert [effect.name for effect in verdict.effects] == ["gps_latency"]
    size = verdict.effects[0].sizes[0]
    assert abs(size.value - 0.3) < size.two_sigma
    notes = " ".join(verdict.notes)
    assert "no aircraft model" in notes
    assert "header" not in notes  # no temperature is asked of it: there is no airplane to fly in it
    assert "belly_pod" not in notes  # nobody expects an airplane's effect without an airplane
    assert "all of engine instruments" in notes


def test_the_belly_pod_is_named_with_its_size_and_closes_the_gap(pod) -> None:
    assert [effect.name for effect in pod.effects] == ["belly_pod"]
    size = pod.effects[0].sizes[0]
    assert abs(size.value - 0.12) < size.two_sigma < 0.04
    assert pod.closure.share > 0.9
    assert pod.located[0].channel == "specific_force_x"


def test_the_verdict_is_plain_data_and_its_patch_an_entry_of_a_case_file(pod) -> None:
    document = verdict_json(pod)
    assert document["verdict"] == pod.kind
    assert document["gap_before"] > document["gap_after"]
    (gap,) = document["gaps"]
    assert (gap["part"], gap["causes"][0]["acts_on"]) == ("drag", "aircraft")
    assert gap["causes"][0]["parameters"][0]["name"] == "drag_area_m2"
    (entry,) = read_case(patch_of_effects(pod.effects, "flight.csv", "2026-01-01").text).effects
    assert entry.name == "belly_pod"
    assert entry.parameters["drag_area_m2"] == pytest.approx(
        pod.effects[0].sizes[0].value, rel=1e-4
    )


def test_the_card_comes_from_the_header_without_its_effects(sensed) -> None:
    card = card_of(sensed("pitot_lag").header, "navajo")
    assert (card.maneuver, card.das.label, card.effects) == ("rapid_decel", "20/1", ())
    assert card_of({}, "navajo") is None


def test_an_unknown_aircraft_and_a_log_without_attitude_are_refused(sensed) -> None:
    with pytest.raises(UnknownNameError, match="Known"):
        judge_logs([NamedLog("log", sensed())], "navayo")
    with pytest.raises(BadInputError, match="attitude"):
        judged(replace(sensed(), roll=None, pitch=None, heading=None))


def test_another_form_of_a_cause_counts_as_that_cause(sensed) -> None:
    """A receiver that smooths is late; the plain latency and its other form are no alternatives of
    each other.
    """
    verdict = judged(sensed("gps_smoothing", das="20/20"))
    assert verdict.kind in ("named", "one_of")
    assert {cause_of(effect.name) for effect in verdict.effects} == {"gps_latency"}
    for effect, others in zip(verdict.effects, verdict.alternatives, strict=True):
        assert cause_of(effect.name) not in map(cause_of, others)


# It declares no speed of its governors, and its engines state no fuel flow for their power.
LACKING = {"governor_speed", "power_deficit"}
FEW = Catalog(
    "effect",
    {n: EFFECTS[n] for n in ("belly_pod", "mass", "pitot_lag", "gps_latency", *sorted(LACKING))},
)


def test_the_bench_s_own_twin_takes_every_effect_and_another_does_not():
    for aircraft, lacking in (("navajo", set()), ("c310", LACKING)):
        baseline = aircraft_model(aircraft).baseline
        effects = {name: each for name, each in EFFECTS.items() if isinstance(each, AircraftEffect)}
        assert {name for name, each in effects.items() if not each.fitting(baseline)} == lacking


def test_the_force_meter_takes_what_an_airplane_has():
    """One engine has one throttle."""
    single, twin = (aircraft_model(name) for name in ("c172x", "c310"))
    assert "throttle_right" not in single.controls
    assert set(twin.controls) - set(single.controls) == {"throttle_right"}


LATE = Catalog("effect", {"gps_latency": EFFECTS["gps_latency"]})


@pytest.fixture(scope="module")
def late_receiver(sensed):
    """A late log, its layout, and what was fitted to it."""
    log = sensed("gps_latency", das="20/20")
    layout = lay_out(log, None, AnalysisSetting(), LATE)
    null = theoretical_distribution(layout)
    return log, layout, null, fit_gaps([layout], [null])


@pytest.mark.parametrize("missing", [(), ("velocity_down", "altitude")])
def test_a_held_out_log_may_lack_channels(late_receiver, missing: tuple[str, ...]) -> None:
    """A log without the vertical velocity and the height ended with an error."""
    log, layout, null, fitted = late_receiver
    assert [member.name for member in fitted.members] == ["gps_latency"]
    held = replace(log, **dict.fromkeys(missing))
    assert hold_out(partial(lay_out, held, None, layout.setting), null, fitted).share > 0.9


@pytest.mark.parametrize("event", ["updraft", "sea_breeze_front"])
def test_an_event_does_not_return_in_another_flight(event: str) -> None:
    assert not returns(event)
    assert returns("gps_latency")


def test_a_second_gap_of_a_sensor_may_be_the_form_of_a_larger_one_of_its_part() -> None:
    """A recovery that grows is no bias beside it; two coefficients of a file are two."""

    def gap(name: str, log_bayes_factor: float) -> FoundGap:
        return FoundGap(FittedHypothesis(name, (), np.zeros(0)), log_bayes_factor)

    recovery, bias, wind = (
        gap("recovery_deficit", 900.0),
        gap("temperature_bias", 45.0),
        gap("wind_drift", 40.0),
    )
    every = (recovery, bias, wind)
    assert [may_be_form(each, every) for each in every] == [False, True, False]
    terms = (gap("lift_slope", 900.0), gap("pitch_damping", 45.0))
    assert not any(may_be_form(each, terms) for each in terms)
