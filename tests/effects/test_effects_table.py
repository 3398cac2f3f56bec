"""Over the whole table: what an effect says of itself is so. A newcomer is tested with no further line."""

import inspect
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.effects.sample_signals import turning

from pitotbench.bench.null_flights import aircraft_model
from pitotbench.effects import EFFECTS, chosen
from pitotbench.effects.choice import effects_table
from pitotbench.effects.effect import AircraftEffect, AirEffect
from pitotbench.effects.response import Signals
from pitotbench.records import BadInputError
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.case_file import read_case, write_case
from pitotbench.simulation.maneuvers import MANEUVERS

UNSHAPED = [
    name
    for name, effect in EFFECTS.items()
    if isinstance(effect, AircraftEffect) and not any(p.shape for p in effect.parameters)
]
SENSORS = [name for name, effect in EFFECTS.items() if effect.acts_on == "sensors"]
DOCUMENT = Path(__file__).parents[2] / "docs" / "effects.md"


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_is_described_and_its_numbers_are_in_order(name):
    effect = EFFECTS[name]
    assert effect.name == name
    assert effect.what.endswith(".")
    assert len(effect.source) > 15
    assert effect.variant_of == "" or effect.variant_of in EFFECTS
    assert any(not p.shape for p in effect.parameters)
    for p in effect.parameters:
        assert p.low <= p.typical <= p.high
        assert p.low < p.high
        assert p.typical != 0.0 or p.shape
    assert effect.acts_on != "sensors" or effect.changes


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_names_a_known_maneuver_that_shows_it(name):
    shown = EFFECTS[name].shows_in
    assert shown.maneuvers
    assert set(shown.maneuvers) <= set(MANEUVERS)
    assert len(shown.text) > 15


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_survives_a_case_file(name):
    case = Case(effects=(EffectSpec(name, EFFECTS[name].typical()),))
    back = read_case(write_case(case))
    assert back == case
    (choice,) = chosen(back.effects)
    assert choice.effect is EFFECTS[name]
    assert dict(choice.sizes) == EFFECTS[name].typical()


@pytest.mark.parametrize("name", SENSORS)
def test_a_sensor_effect_changes_what_it_says_and_nothing_else(name):
    effect, signals = EFFECTS[name], turning()
    felt = effect.apply(signals, effect.typical())
    changed = {channel for channel in signals if not np.array_equal(felt[channel], signals[channel])}
    assert changed == {*effect.changes, *effect.also}
    assert set(felt) == set(signals)
    assert np.array_equal(felt.time, signals.time)
    assert all(np.isfinite(felt[channel]).all() for channel in felt)


@pytest.mark.parametrize("name", SENSORS)
def test_zero_size_is_identity(name):
    effect, signals = EFFECTS[name], turning(20.0)
    zero = {p.name: 0.0 for p in effect.parameters if not p.shape}
    felt = effect.apply(signals, zero)
    assert all(np.array_equal(felt[channel], signals[channel]) for channel in signals)


@pytest.mark.parametrize("name", [n for n in SENSORS if n not in ("saturation", "quantization", "dropped_samples")])
def test_a_small_effect_is_small(name):
    """No effect jumps at zero: a thousandth of the typical size does at most a hundredth of its work."""
    effect, signals = EFFECTS[name], turning(60.0)
    shapes = {p.name: p.typical for p in effect.parameters if p.shape}
    small = {p.name: 1e-3 * p.typical for p in effect.parameters if not p.shape}
    full, slight = effect.apply(signals, effect.typical()), effect.apply(signals, {**small, **shapes})
    for channel in effect.changes:
        work, little = np.ptp(full[channel] - signals[channel]), np.ptp(slight[channel] - signals[channel])
        mean, trifle = np.mean(full[channel] - signals[channel]), np.mean(slight[channel] - signals[channel])
        assert little <= 1e-2 * work + 1e-9
        assert abs(trifle) <= 1e-2 * max(abs(mean), work) + 1e-9


@pytest.mark.parametrize("name", SENSORS)
def test_a_missing_channel_is_named(name):
    effect, signals = EFFECTS[name], turning(10.0)
    for channel in (*effect.needs, *effect.changes):
        without = Signals(signals.time, {k: v for k, v in signals.channels.items() if k != channel})
        with pytest.raises(BadInputError, match=f"{name}.*{channel}"):
            effect.apply(without, effect.typical())


def test_the_document_holds_the_table():
    assert DOCUMENT.read_text(encoding="utf-8").endswith("\n\n" + effects_table(EFFECTS.values()))


def test_every_effect_of_a_page_is_in_the_table():
    """No effect is defined without a line in the table."""
    from importlib import import_module

    root = Path(inspect.getfile(AirEffect)).parent
    modules = [f"pitotbench.effects.{f.stem}" for f in root.glob("*.py") if f.stem != "__init__"]
    found = [
        value
        for module in map(import_module, modules)
        for value in vars(module).values()
        if type(value) in {type(effect) for effect in EFFECTS.values()}
    ]
    assert {effect.name for effect in found} == set(EFFECTS)


@pytest.mark.parametrize("name", UNSHAPED)
def test_an_effect_on_top_of_itself_is_one_of_both_sizes(name):
    effect, model = EFFECTS[name], aircraft_model("navajo")

    def of(share):
        return effect.overlay({p.name: share * p.typical for p in effect.parameters}, model.baseline)

    both, whole = of(0.25) + of(1.0), of(1.25)
    assert dict(both.sizes) == pytest.approx(dict(whole.sizes))
    assert both.temperature_offset == pytest.approx(whole.temperature_offset)
    assert replace(both, sizes=(), temperature_offset=0.0) == replace(whole, sizes=(), temperature_offset=0.0)
