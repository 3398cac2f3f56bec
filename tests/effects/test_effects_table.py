"""What an effect of the table says of itself is so, also for a part of a flight; a case's effects,
or one error.
"""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from tests.effects.sample_signals import turning

from pitotbench import BadInputError, Case, UnknownNameError, read_case, write_case
from pitotbench.effects import EFFECTS, FORMS, FORMULAS, chosen
from pitotbench.effects.effect import AircraftEffect, AirEffect, Part
from pitotbench.effects.overlay import Baseline, evaluate
from pitotbench.effects.response import Signals
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.records.case import EffectSpec
from pitotbench.simulation.maneuvers import MANEUVERS

UNSHAPED = [
    name
    for name, effect in EFFECTS.items()
    if isinstance(effect, AircraftEffect) and not any(p.shape for p in effect.parameters)
]
SENSORS = [name for name, effect in EFFECTS.items() if effect.acts_on == "sensors"]


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_is_described_and_its_numbers_are_in_order(name):
    effect = EFFECTS[name]
    assert effect.name == name
    assert effect.what.endswith(".")
    assert effect.source
    assert effect.variant_of == "" or effect.variant_of in EFFECTS
    assert any(not p.shape for p in effect.parameters)
    for p in effect.parameters:
        assert p.low <= p.typical <= p.high
        assert p.low < p.high
        assert p.typical != 0.0 or p.shape
    assert effect.acts_on != "sensors" or effect.changes
    # A known maneuver shows it.
    assert set() < set(effect.shows_in.maneuvers) <= set(MANEUVERS)
    assert effect.shows_in.text


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
    changed = {
        channel for channel in signals if not np.array_equal(felt[channel], signals[channel])
    }
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


@pytest.mark.parametrize(
    "name", [n for n in SENSORS if n not in ("saturation", "quantization", "dropped_samples")]
)
def test_a_small_effect_is_small(name):
    """No effect jumps at zero: a thousandth of the typical size does at most a hundredth of its
    work.
    """
    effect, signals = EFFECTS[name], turning(60.0)
    shapes = {p.name: p.typical for p in effect.parameters if p.shape}
    small = {p.name: 1e-3 * p.typical for p in effect.parameters if not p.shape}
    full, slight = (
        effect.apply(signals, effect.typical()),
        effect.apply(signals, {**small, **shapes}),
    )
    for channel in effect.changes:
        work, little = (
            np.ptp(full[channel] - signals[channel]),
            np.ptp(slight[channel] - signals[channel]),
        )
        mean, trifle = (
            np.mean(full[channel] - signals[channel]),
            np.mean(slight[channel] - signals[channel]),
        )
        assert little <= 1e-2 * work + 1e-9
        assert abs(trifle) <= 1e-2 * max(abs(mean), work) + 1e-9


@pytest.mark.parametrize("name", SENSORS)
def test_a_missing_channel_is_named(name):
    effect, signals = EFFECTS[name], turning(10.0)
    for channel in (*effect.needs, *effect.changes):
        without = Signals(signals.time, {k: v for k, v in signals.channels.items() if k != channel})
        with pytest.raises(BadInputError, match=f"{name}.*{channel}"):
            effect.apply(without, effect.typical())


def test_an_effect_of_one_model_has_the_terms_of_a_plain_effect():
    """Neither a form in time nor an effect on other channels is one model with another."""
    twins = {name: effect.one_model_with for name, effect in FORMS.items() if effect.one_model_with}
    assert twins == {"impact_pressure_scale": "total_pressure_loss", "gear_not_up": "belly_pod"}
    for name, plain in twins.items():
        assert EFFECTS[plain].cause == plain
        assert EFFECTS[name].changes == EFFECTS[plain].changes


@pytest.mark.parametrize("name", UNSHAPED)
def test_an_effect_on_top_of_itself_is_one_of_both_sizes(name):
    effect, model = EFFECTS[name], aircraft_model("navajo")

    def of(share):
        return effect.overlay(
            {p.name: share * p.typical for p in effect.parameters}, model.baseline
        )

    both, whole = of(0.25) + of(1.0), of(1.25)
    assert dict(both.sizes) == pytest.approx(dict(whole.sizes))
    assert both.temperature_offset == pytest.approx(whole.temperature_offset)
    assert replace(both, sizes=(), temperature_offset=0.0) == replace(
        whole, sizes=(), temperature_offset=0.0
    )


LAG = EffectSpec("pitot_lag", {"lag_s": 0.3})
BAD = {
    "unknown parameter": (
        [EffectSpec("pitot_lag", {"lag_ms": 300.0, "lag_s": 0.3})],
        r"pitot_lag: unknown parameter 'lag_ms'.*lag_s",
    ),
    "missing": ([EffectSpec("pitot_lag")], r"pitot_lag: lag_s is missing \(typically 0.4"),
    "too large": (
        [EffectSpec("pitot_lag", {"lag_s": 50.0})],
        r"pitot_lag: lag_s = 50 is not within 0.01 to 3",
    ),
    "wrong sign": ([EffectSpec("pitot_lag", {"lag_s": -0.2})], r"lag_s = -0.2 is not within"),
    "not a number": (
        [EffectSpec("pitot_lag", {"lag_s": float("nan")})],
        r"lag_s = nan is not within",
    ),
    "all at once": (
        [EffectSpec("pitot_lag"), EffectSpec("belly_pod", {"drag_area_m2": 9.0})],
        r"pitot_lag: lag_s is missing.*belly_pod: drag_area_m2 = 9",
    ),
    "twice": ([LAG, LAG], "pitot_lag: named 2 times"),
    "unknown": ([replace(LAG, name="pitot_lagg")], "Did you mean 'pitot_lag'"),
}


@pytest.mark.parametrize("what", BAD)
def test_each_problem_is_named(what):
    effects, message = BAD[what]
    with pytest.raises((BadInputError, UnknownNameError), match=message):
        chosen(effects)


def test_shapes_may_be_left_out_and_zero_is_none():
    (choice,) = chosen(
        [EffectSpec("second_order_line", {"lag_s": 0.3}), EffectSpec("pitot_lag", {"lag_s": 0.0})]
    )
    assert choice.effect.complete(choice.sizes) == {"lag_s": 0.3, "damping": 0.6}


def test_every_effect_states_its_part_in_every_form_and_a_formula_has_none():
    assert all(form.part in get_args(Part) and form.part for form in FORMS.values())
    assert not any(formula.part for formula in FORMULAS.values())
    assert {form.part for form in FORMS.values()} == set(get_args(Part)) - {""}
    assert all(EFFECTS[e.variant_of].part == e.part for e in FORMS.values() if e.variant_of)


def test_an_effect_with_a_defining_size_is_its_neighbor_without_it():
    defined = {n: e for n, e in EFFECTS.items() if any(p.defining for p in e.parameters)}
    assert defined
    assert {n for n, e in EFFECTS.items() if e.neighbor} == set(defined)
    for effect in defined.values():
        neighbor = EFFECTS[effect.neighbor]
        assert neighbor.part == effect.part
        if isinstance(effect, AircraftEffect):
            continue  # on the force meter: tests/simulation/test_force_meter.py
        sizes = {p.name: 0.0 if p.defining else 0.4 for p in effect.parameters}
        plain = {p.name: 0.4 for p in neighbor.parameters}
        signals = turning()
        with_it, without = effect.apply(signals, sizes), neighbor.apply(signals, plain)
        for channel in effect.changes:
            np.testing.assert_allclose(with_it[channel], without[channel], rtol=1e-9)


TIMED = [name for name in EFFECTS if f"{name}_for_a_time" in FORMS]
TIMED_SENSORS = [name for name in TIMED if EFFECTS[name].acts_on == "sensors"]
WINDS = [
    name
    for name in TIMED
    if isinstance(EFFECTS[name], AirEffect) and EFFECTS[name].wind is not None
]
BETWEEN = {"from_s": 40.0, "to_s": 80.0}


def test_only_effects_with_times_of_their_own_and_warmer_air_have_no_such_form():
    assert set(EFFECTS) - set(TIMED) == {"nonstandard_temperature", "sea_breeze_front", "updraft"}


@pytest.mark.parametrize("name", TIMED_SENSORS)
@pytest.mark.parametrize("times", [BETWEEN, {"from_s": 40.0}], ids=["between", "from a time on"])
def test_a_sensor_effect_acts_between_its_times_only(name, times):
    signals = turning()
    since, end = signals.time - signals.time[0], times.get("to_s", np.inf)
    (choice,) = chosen([EffectSpec(name, {**EFFECTS[name].typical(), **times})])
    whole, part = (
        EFFECTS[name].apply(signals, EFFECTS[name].typical()),
        choice.effect.apply(signals, choice.sizes),
    )
    outside, inside = (since <= 40.0) | (since >= end), (since >= 42.0) & (since <= end - 2.0)
    for channel in signals:
        np.testing.assert_array_equal(part[channel][outside], signals[channel][outside])
        np.testing.assert_array_equal(part[channel][inside], whole[channel][inside])


def test_a_heading_fades_in_across_north_the_short_way():
    signals = turning(60.0)
    signals = signals.with_channels(
        heading=np.mod(0.02 * (signals.time - signals.time[0]) - 0.63, 2.0 * np.pi)
    )
    (choice,) = chosen([EffectSpec("gps_latency", {"latency_s": 0.3, "from_s": 30.0})])
    (turned,) = chosen([EffectSpec("inertial_unit_misalignment", {
        "roll_deg": 0.0, "pitch_deg": 0.0, "yaw_deg": 5.0, "from_s": 30.0})])  # fmt: skip
    felt = turned.effect.apply(choice.effect.apply(signals, choice.sizes), turned.sizes)["heading"]
    error = np.mod(felt - signals["heading"] + np.pi, 2.0 * np.pi) - np.pi
    assert error.min() > -1e-9
    assert error.max() < 0.1  # 5°, and a little more with the nose up


@pytest.mark.parametrize("name", WINDS)
def test_a_wind_blows_between_its_times_only(name):
    signals = turning()
    since = signals.time - signals.time[0]
    (choice,) = chosen([EffectSpec(name, {**EFFECTS[name].typical(), **BETWEEN})])
    whole = EFFECTS[name].wind(signals, EFFECTS[name].typical())
    part = choice.effect.wind(signals, choice.effect.complete(choice.sizes))
    share = np.interp(since, [40.0, 42.0, 78.0, 80.0], [0.0, 1.0, 1.0, 0.0])
    for one, other in zip(whole, part, strict=True):
        np.testing.assert_allclose(other, share * one, atol=1e-12)


def test_a_force_of_the_airplane_grows_and_fades_with_its_share():
    (choice,) = chosen([EffectSpec("belly_pod", {"drag_area_m2": 0.2, **BETWEEN})])
    overlay = choice.effect.overlay(choice.sizes, Baseline("none", (0.0, 0.0, 0.0)))
    time = np.array([0.0, 40.0, 41.0, 60.0, 79.5, 80.0, 200.0])
    there = {
        "simulation/sim-time-sec": 500.0 + time,
        "bench/recording-start-s": 500.0,
        "aero/qbar-psf": 10.0,
    }
    drag = evaluate(overlay.functions[0].value, {**there, **dict(overlay.sizes)})
    np.testing.assert_allclose(
        drag, 10.0 * 0.2 / 0.3048**2 * np.array([0.0, 0.0, 0.5, 1.0, 0.25, 0.0, 0.0])
    )


def test_a_case_file_names_the_times_beside_the_sizes():
    text = (
        '[[effects]]\nname = "flap_not_up"\nparameters = { extension = 0.2, from_s = 60.0, '
        "to_s = 140.0 }\n"
    )
    case = read_case(text)
    assert read_case(write_case(case)) == case
    (choice,) = chosen(case.effects)
    assert choice.effect.part_of == "flap_not_up"
    assert choice.effect.cause == "flap_not_up"


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        (
            "pitot_lag",
            {"lag_s": 0.3, "from_s": 80.0, "to_s": 60.0},
            "to_s is not later than from_s",
        ),
        ("pitot_lag", {"lag_s": 0.3, "to_s": 60.0}, "unknown parameter 'to_s'"),
        ("pitot_lag", {"lag_s": 0.3, "from_s": -5.0}, "from_s = -5 is not within"),
        ("nonstandard_temperature", {"warmer_k": 5.0, "from_s": 9.0}, "unknown parameter 'from_s'"),
    ],
)
def test_impossible_times_are_refused(name, parameters, message):
    with pytest.raises(BadInputError, match=message):
        chosen([EffectSpec(name, parameters)])


def test_typical_sizes_and_ranges_grow_with_the_airplane():
    mass = EFFECTS["mass"].parameter("mass_kg")
    assert mass.of_airplane(aircraft_model("navajo").baseline) == mass
    small = mass.of_airplane(aircraft_model("aerosonde").baseline)  # of 13.5 kg, and 1,842 kg
    shrunk = np.array([small.typical, small.low, small.high])
    assert np.allclose(shrunk, np.array([150.0, -600.0, 600.0]) * 13.5 / 1841.6, rtol=1e-4)
    assert mass.of_airplane(Baseline("unknown", (0.0, 0.0, 0.0))) == mass
    share = EFFECTS["lift_slope"].parameter("change")
    assert share.of_airplane(aircraft_model("aerosonde").baseline) == share
