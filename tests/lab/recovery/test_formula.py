"""Formulas: effects that are coefficients of terms, and the search for them where the table has no
name.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.reconciliation.outside_table import OUTSIDERS, day, edited, flown

from pitotbench import BadInputError, FlightLog, fly, read_case, sense, write_case
from pitotbench.catalog import Catalog
from pitotbench.effects import Effect, chosen
from pitotbench.effects.formula import (
    FORCE_FORMULAS,
    FORCE_TERMS,
    FORMULAS,
    READINGS,
    TERMS,
    values_of,
)
from pitotbench.effects.overlay import Overlay, evaluate, properties_in
from pitotbench.effects.response import Signals
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.formula import signatures_at
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.null_distribution import theoretical_distribution
from pitotbench.reconciliation.replay import answer, coarse_rows, motion_of
from pitotbench.reconciliation.residuals import FORCES, MOMENTS, change_by_answer
from pitotbench.reconciliation.verdict import Judged, judge
from pitotbench.records.case import EffectSpec

HELD = ("map-inhg", "propeller-rpm", "engine[")  # engines do not run in a state that is held


NO_EFFECTS: Catalog[Effect] = Catalog("effect", {})
SETTING = AnalysisSetting(day_known=True)


def laid_out(log: FlightLog) -> Layout:
    return lay_out(log, aircraft_model("navajo"), SETTING, NO_EFFECTS)


def judged(log: FlightLog) -> Judged:
    """A log by formulas alone, in the noise that it shows itself: no null flight is flown."""
    layout = laid_out(log)
    return judge(["log"], [layout], [theoretical_distribution(layout)])


@pytest.fixture(scope="module")
def slipping(tmp_path_factory: pytest.TempPathFactory) -> FlightLog:
    """A flight of an airplane whose file was edited: 3 sin²β more drag."""
    return flown(OUTSIDERS["drag in sideslip"], 41, tmp_path_factory.mktemp("shelf"), "20/20")


@pytest.fixture(scope="module")
def layout(slipping: FlightLog) -> Layout:
    return laid_out(slipping)


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
    clean = layout.reference.clean
    rows = coarse_rows(clean)
    paths = {
        p
        for name in FORCE_TERMS
        for p in properties_in(TERMS[name].value)
        if not any(h in p for h in HELD)
    }
    units = layout.reference.force_model.aircraft.unit_forces(
        motion_of(clean, rows), frozenset(paths)
    )
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
    (signature,) = signatures_at(layout.reference, {key: size})
    reference, model = layout.reference, layout.reference.force_model
    overlay = FORMULAS[name].overlay({"sideslip": size}, model.aircraft.baseline)
    every = model.replay.rows
    motion = motion_of(reference.clean, every)
    without, with_it = (
        answer(lambda states, o=each: model.aircraft.react(states, o, False), motion)
        for each in (Overlay(), overlay)
    )
    measured = change_by_answer(
        reference.base.names, reference.clean, reference.grid, every, without - with_it
    )
    for column in range(measured.shape[1]):
        if reference.base.names[column] not in (*FORCES, *MOMENTS):
            continue  # of the engines, whose power a held airplane does not tell
        largest = np.max(np.abs(measured[:, column]))
        if largest > 1e-3 * np.max(np.abs(measured)):
            error = np.max(np.abs(measured[:, column] / size - signature.column[:, column]))
            assert error < 0.1 * largest / size


@pytest.fixture(scope="module")
def signals(slipping) -> Signals:
    channels = {n: v for n, v in slipping.channels().items() if v.dtype == float and n != "time"}
    return Signals(slipping.time, channels)


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
    signals = Signals(slipping.time, {"heading": slipping.heading})
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
