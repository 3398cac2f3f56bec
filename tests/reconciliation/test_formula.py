"""Formulas: effects that are coefficients of terms, and the search for them where the table has no
name.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.reconciliation.outside_table import OUTSIDERS, day, edited, flown

from pitotbench import BadInputError, FlightLog, fly, read_case, sense, write_case
from pitotbench.bench.null_flights import aircraft_model
from pitotbench.effects import chosen
from pitotbench.effects.effect import Parameter
from pitotbench.effects.formula import (
    FORCE_FORMULAS,
    FORCE_TERMS,
    FORMULAS,
    READINGS,
    TERMS,
    values_of,
)
from pitotbench.effects.overlay import evaluate, properties_in
from pitotbench.effects.response import Signals
from pitotbench.reconciliation.equations import equations_from, scaled_to
from pitotbench.reconciliation.formula import (
    choose_terms,
    closure_on,
    find_formula,
    folded_equations,
    free_sizes_beside,
    signatures_at,
)
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.null_distribution import NullDistribution, theoretical_distribution
from pitotbench.reconciliation.renewal import lay_out_with
from pitotbench.reconciliation.residuals import change_by_answer
from pitotbench.reconciliation.track import COARSE, motion_of, replay_rows, spread
from pitotbench.reconciliation.verdict import for_channels
from pitotbench.records.case import EffectSpec
from pitotbench.records.gap import FoundFormula
from pitotbench.show.gap_words import formula_sentences

HELD = ("map-inhg", "propeller-rpm", "engine[")  # engines do not run in a state that is held


def laid_out(log: FlightLog) -> Layout:
    return lay_out_with(log, aircraft_model("navajo"), AnalysisSetting(day_known=True), {})


def null_of(layout: Layout) -> NullDistribution:
    """The noise that a log itself shows: no null flight is flown."""
    return theoretical_distribution(layout)


@pytest.fixture(scope="module")
def slipping(tmp_path_factory: pytest.TempPathFactory) -> tuple[FlightLog, FlightLog]:
    """Two flights of an airplane whose file was edited: 3 sin²β more drag."""
    folder, hidden = tmp_path_factory.mktemp("shelf"), OUTSIDERS["drag in sideslip"]
    return flown(hidden, 41, folder, "20/20"), flown(hidden, 42, folder, "20/20")


@pytest.fixture(scope="module")
def layout(slipping: tuple[FlightLog, FlightLog]) -> Layout:
    return laid_out(slipping[0])


@pytest.fixture(scope="module")
def found(layout: Layout) -> FoundFormula:
    return find_formula(layout, null_of(layout))


def test_the_drag_in_sideslip_is_found_with_its_coefficient_and_closes_another_flight(
    found, slipping
):
    (term,) = found.terms
    assert (term.quantity, term.symbol, term.term) == ("drag", "ΔC_D", "sin²β")
    assert abs(term.size.value - 3.0) < term.size.two_sigma < 0.75
    said = r"The gap follows a formula: drag: ΔC_D = \(\d\.\d+ ± 0\.\d+\) sin²β; ± is 2σ\."
    assert re.match(said, formula_sentences(found, "other.csv")[0])
    other = laid_out(slipping[1])
    assert closure_on(other, null_of(other), found).share > 0.8
    assert found.closure.share > 0.9
    fewer = laid_out(
        replace(slipping[1], velocity_down=None)
    )  # the flight held out may lack a channel
    assert len(fewer.residuals.names) < len(other.residuals.names)
    assert closure_on(fewer, for_channels(null_of(other), fewer), found).share > 0.8


def test_a_term_whose_coefficient_is_outside_its_range_is_none(layout, found, monkeypatch):
    """The range of all coefficients is made a hundredth of what it is."""
    monkeypatch.setattr(
        Parameter, "within", lambda self, value: min(max(value, self.low / 100), self.high / 100)
    )
    instead = find_formula(layout, null_of(layout))
    terms = instead.terms if instead else ()
    assert found.terms[0].effect not in [term.effect for term in terms]
    for term in terms:
        own = FORMULAS[term.effect].parameter(term.size.name)
        assert abs(term.size.value) <= own.high / 100


def test_a_flight_without_a_gap_has_no_formula_and_beside_one_a_gap_does_not_bend_the_error_curve(
    tmp_path,
):
    """The left fuel flow reads 8 % low, no matter of the error curve. Without the formula it seems
    to be.
    """
    plain = flown(None, 43, tmp_path, "20/20")
    sound, low = (
        laid_out(plain),
        laid_out(replace(plain, fuel_flow_left=0.92 * plain.fuel_flow_left)),
    )
    null = null_of(sound)
    assert find_formula(sound, null) is None
    formula = find_formula(low, null)
    true, bent = (
        folded_equations(replace(each, signatures=()), scaled_to(null.noise, each)).free_sizes()
        for each in (sound, low)
    )
    found = free_sizes_beside(low, null, formula)
    curve = [i for i, name in enumerate(sound.free.names) if name.startswith("curve")]
    assert len(curve) == 3
    for i in curve:
        assert abs(found[sound.free.names[i]] - true[i]) < 0.1 * abs(bent[i] - true[i])


def test_a_formula_flies_as_the_edited_file_does(tmp_path):
    """The overlay of a formula and a function written into the airplane's file give one flight."""
    case = replace(day(44), turbulence="none")
    with edited(OUTSIDERS["drag in sideslip"], tmp_path) as name:
        by_hand = fly(replace(case, aircraft=name))
    entry = EffectSpec("drag_formula", {"sideslip_squared": 3.0})
    by_formula, plain = fly(replace(case, effects=(entry,))), fly(case)
    rows = min(len(f["time"]) for f in (by_hand, by_formula, plain))
    hand, formula, without = (f["throttle_left"][:rows] for f in (by_hand, by_formula, plain))
    assert np.max(np.abs(hand - without)) > 0.01
    # sin²β stands for β²: they differ by 0.2 % at 4°.
    assert np.max(np.abs(hand - formula)) < 0.05 * np.max(np.abs(hand - without))


def test_every_force_formula_loads_and_flies():
    """JSBSim finds every property that a term reads."""
    entries = tuple(EffectSpec(name, dict.fromkeys(FORCE_TERMS, 1e-9)) for name in FORCE_FORMULAS)
    case = replace(day(45, "step_decrease"), turbulence="none", card={"speeds_kt": [150.0, 140.0]})
    plain, flight = fly(case), fly(replace(case, effects=entries))
    assert np.allclose(plain["calibrated_airspeed"], flight["calibrated_airspeed"], atol=0.01)


def test_terms_from_a_log_are_those_of_the_simulator(layout):
    """The properties that JSBSim has in the measured states, against those that are computed from
    the channels.
    """
    clean = layout.scene.clean
    rows = replay_rows(clean, COARSE)
    paths = {
        p
        for name in FORCE_TERMS
        for p in properties_in(TERMS[name].value)
        if not any(h in p for h in HELD)
    }
    units = layout.scene.force_model.aircraft.unit_forces(motion_of(clean, rows), frozenset(paths))
    signals = Signals(
        clean.time[rows], {name: values[rows] for name, values in clean.channels.items()}
    )
    for name in FORCE_TERMS:
        read = properties_in(TERMS[name].value)
        if not read or not read <= paths:
            continue
        simulated = evaluate(TERMS[name].value, units.properties)
        deviation = np.abs(values_of(TERMS[name], signals) - simulated)
        assert np.quantile(deviation, 0.95) < 0.1 * TERMS[name].usual, name


@pytest.mark.parametrize("name", FORCE_FORMULAS)
def test_a_signature_of_a_force_is_that_of_the_force_meter(layout, name):
    key = (name, "sideslip")
    size = FORMULAS[name].parameter("sideslip").typical
    (signature,) = signatures_at(layout.scene, {key: size})
    scene, model = layout.scene, layout.scene.force_model
    overlay = FORMULAS[name].overlay({"sideslip": size}, model.aircraft.baseline)
    every, coarse = model.replay.rows, replay_rows(scene.clean, COARSE)
    lost = spread(every, coarse, model.missing(overlay, False))
    measured = change_by_answer(scene.base.names, scene.clean, scene.grid, every, lost)
    for column in range(measured.shape[1]):
        largest = np.max(np.abs(measured[:, column]))
        if largest > 1e-3 * np.max(np.abs(measured)):
            error = np.max(np.abs(measured[:, column] / size - signature.column[:, column]))
            assert error < 0.1 * largest / size


@pytest.fixture(scope="module")
def signals(slipping) -> Signals:
    channels = {n: v for n, v in slipping[0].channels().items() if v.dtype == float and n != "time"}
    return Signals(slipping[0].time, channels)


def test_a_static_pressure_formula_is_that_by_hand(signals):
    wrong = FORMULAS["static_pressure_formula"].apply(
        signals, {"elevator": 0.8, "bank_squared": -0.1}
    )
    error = (0.8 * signals["elevator"] - 0.1 * np.sin(signals["roll"]) ** 2) * signals[
        "impact_pressure"
    ]
    assert np.allclose(wrong["static_pressure"] - signals["static_pressure"], error)
    assert np.allclose(wrong["impact_pressure"] - signals["impact_pressure"], -error)


@pytest.mark.parametrize("name", READINGS)
def test_a_sensor_formula_changes_its_channels_alone(signals, name):
    changed = FORMULAS[name].apply(signals, FORMULAS[name].typical())
    moved = {n for n in signals if not np.array_equal(changed[n], signals[n])}
    assert moved == set(READINGS[name].channels)


def test_a_missing_coefficient_is_zero_and_a_missing_channel_is_named(slipping):
    entry = EffectSpec("heading_formula", {"heading_north_deg": 2.0})
    case = replace(day(1), effects=(entry,))
    assert read_case(write_case(case)) == case
    (choice,) = chosen([entry])
    signals = Signals(slipping[0].time, {"heading": slipping[0].heading})
    turned = choice.effect.apply(signals, choice.sizes)
    assert np.allclose(
        np.degrees(turned["heading"] - signals["heading"]), 2.0 * np.cos(signals["heading"])
    )
    with pytest.raises(BadInputError, match="roll"):
        choice.effect.apply(signals, {"bank_deg": 1.0})


def test_a_formula_recorded_is_the_log_with_the_error(tmp_path: Path):
    """The sensors of the bench apply a formula, as the patch asks them to."""
    case = replace(day(46, "step_decrease"), turbulence="none", card={"speeds_kt": [150.0, 140.0]})
    entry = EffectSpec("temperature_formula", {"power_k": 4.0})
    plain, warm = (sense(fly(c), "20/1") for c in (case, replace(case, effects=(entry,))))
    assert np.mean(warm.total_temperature - plain.total_temperature) > 1.0


def _equations(columns: np.ndarray, response: np.ndarray):
    every = np.column_stack([np.ones(len(response)), columns, response])
    parts = np.array_split(every, 8)
    return equations_from(np.stack([part.T @ part for part in parts]), 1, np.array([10.0]))


def test_noise_chooses_no_term_and_a_planted_pair_is_found():
    draw = np.random.default_rng(5)
    columns = draw.normal(size=(800, 200))
    noise = draw.normal(size=800)
    assert choose_terms(_equations(columns, noise), range(200)) is None
    planted = choose_terms(
        _equations(columns, noise + 0.8 * columns[:, 17] - 0.4 * columns[:, 90]), range(200)
    )
    assert set(planted.columns) == {17, 90}
    assert planted.alike == ((), ())
    # A term that does as well is told.
    columns[:, 1] = columns[:, 0] + 0.02 * columns[:, 1]
    found = choose_terms(_equations(columns[:, :50], noise + columns[:, 0]), range(50))
    assert set(found.columns) | set(found.alike[0]) == {0, 1}


def test_a_term_of_one_moment_does_not_hold_out():
    """A column that explains one fold and not the others has no gain where that fold is left out."""
    draw = np.random.default_rng(7)
    burst = np.zeros(800)
    burst[100:200] = 3.0 * draw.normal(size=100)
    column, noise = (
        burst + np.where(burst == 0.0, draw.normal(size=800), 0.0),
        draw.normal(size=800),
    )
    assert choose_terms(_equations(column[:, None], noise + burst), [0]) is None
    assert choose_terms(_equations(column[:, None], noise + column), [0]) is not None
