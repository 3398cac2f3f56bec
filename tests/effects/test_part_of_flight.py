"""Every effect of the table, for a part of the flight: nothing outside, the whole effect inside."""

import numpy as np
import pytest
from tests.effects.sample_signals import turning

from pitotbench import BadInputError, read_case, write_case
from pitotbench.effects import EFFECTS, FORMS, chosen
from pitotbench.effects.effect import AirEffect
from pitotbench.effects.overlay import Baseline, evaluate
from pitotbench.records.case import EffectSpec

TIMED = [name for name in EFFECTS if f"{name}_for_a_time" in FORMS]
SENSORS = [name for name in TIMED if EFFECTS[name].acts_on == "sensors"]
WINDS = [name for name in TIMED if isinstance(EFFECTS[name], AirEffect) and EFFECTS[name].wind is not None]
BETWEEN = {"from_s": 40.0, "to_s": 80.0}


def test_only_effects_with_times_of_their_own_and_warmer_air_have_no_such_form():
    assert set(EFFECTS) - set(TIMED) == {"nonstandard_temperature", "sea_breeze_front", "updraft"}


@pytest.mark.parametrize("name", SENSORS)
@pytest.mark.parametrize("times", [BETWEEN, {"from_s": 40.0}], ids=["between", "from a time on"])
def test_a_sensor_effect_acts_between_its_times_only(name, times):
    signals = turning()
    since, end = signals.time - signals.time[0], times.get("to_s", np.inf)
    (choice,) = chosen([EffectSpec(name, {**EFFECTS[name].typical(), **times})])
    whole, part = EFFECTS[name].apply(signals, EFFECTS[name].typical()), choice.effect.apply(signals, choice.sizes)
    outside, inside = (since <= 40.0) | (since >= end), (since >= 42.0) & (since <= end - 2.0)
    for channel in signals:
        np.testing.assert_array_equal(part[channel][outside], signals[channel][outside])
        np.testing.assert_array_equal(part[channel][inside], whole[channel][inside])


def test_a_heading_fades_in_across_north_the_short_way():
    signals = turning(60.0)
    signals = signals.with_channels(heading=np.mod(0.02 * (signals.time - signals.time[0]) - 0.63, 2.0 * np.pi))
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
    there = {"simulation/sim-time-sec": 500.0 + time, "bench/recording-start-s": 500.0, "aero/qbar-psf": 10.0}
    drag = evaluate(overlay.functions[0].value, {**there, **dict(overlay.sizes)})
    np.testing.assert_allclose(drag, 10.0 * 0.2 / 0.3048**2 * np.array([0.0, 0.0, 0.5, 1.0, 0.25, 0.0, 0.0]))


def test_a_case_file_names_the_times_beside_the_sizes():
    text = '[[effects]]\nname = "flap_not_up"\nparameters = { extension = 0.2, from_s = 60.0, to_s = 140.0 }\n'
    case = read_case(text)
    assert read_case(write_case(case)) == case
    (choice,) = chosen(case.effects)
    assert choice.effect.part_of == "flap_not_up"
    assert choice.effect.cause == "flap_not_up"


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("pitot_lag", {"lag_s": 0.3, "from_s": 80.0, "to_s": 60.0}, "to_s is not later than from_s"),
        ("pitot_lag", {"lag_s": 0.3, "to_s": 60.0}, "unknown parameter 'to_s'"),
        ("pitot_lag", {"lag_s": 0.3, "from_s": -5.0}, "from_s = -5 is not within"),
        ("nonstandard_temperature", {"warmer_k": 5.0, "from_s": 9.0}, "unknown parameter 'from_s'"),
    ],
)
def test_impossible_times_are_refused(name, parameters, message):
    with pytest.raises(BadInputError, match=message):
        chosen([EffectSpec(name, parameters)])
