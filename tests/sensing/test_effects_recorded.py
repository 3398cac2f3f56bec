"""The effects of a case in the recorded log: in the right place of the chain, and nowhere told."""

import re
from dataclasses import replace

import numpy as np
import pytest
from tests.sensing import synthetic_flight as fixture

from pitotbench import Flight, FlightLog
from pitotbench.effects import EFFECTS
from pitotbench.records.case import EffectSpec
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.units import INCH_OF_MERCURY

SENSORS = [name for name, effect in EFFECTS.items() if effect.acts_on == "sensors"]


def flown(*effects: EffectSpec, gap: float = 0.0) -> Flight:
    flight = fixture.flight(seconds=40.0, gap=gap, case=fixture.unbiased(effects=effects))
    speeds = {f"propeller_speed_{side}": np.full(len(flight), 270.0) for side in ("left", "right")}
    return replace(flight, channels={**flight.channels, **speeds})


def differing(one: FlightLog, other: FlightLog) -> set[str]:
    a, b = one.channels(), other.channels()
    assert set(a) == set(b)
    return {name for name in a if not np.array_equal(a[name], b[name])}


@pytest.mark.parametrize("name", SENSORS)
def test_a_log_differs_where_the_effect_says(name):
    das = data_system("50/50")
    plain = record(flown(), das, 1)
    log = record(flown(EffectSpec(name, EFFECTS[name].typical())), das, 1)
    allowed = {*EFFECTS[name].changes, *EFFECTS[name].also}
    assert differing(log, plain) <= allowed
    assert name in ("saturation", "temperature_drift") or differing(
        log, plain
    )  # these two are still in this flight


def test_an_effect_that_is_felt_is_lagged_before_the_noise():
    """The same noise on top: it cancels but for one step of rounding."""
    das = data_system("50/50")
    lagged = record(flown(EffectSpec("pitot_lag", {"lag_s": 0.5125})), das, 1)
    difference = lagged.impact_pressure - record(flown(), das, 1).impact_pressure
    smooth = np.convolve(difference, np.ones(9) / 9.0, mode="valid")
    assert np.abs(difference[4:-4] - smooth).max() < 0.5  # the noise is 12 Pa
    assert np.abs(difference).max() > 10.0
    assert not re.search(r"lag|0\.5125", str(lagged.header))  # which tells no effect


def test_the_recorders_faults_come_after_the_noise():
    das = data_system("50/50")
    stored = record(flown(EffectSpec("quantization", {"step_pa": 25.0})), das, 1)
    np.testing.assert_allclose(stored.impact_pressure % 25.0, 0.0)
    held = record(flown(EffectSpec("sample_and_hold", {"period_s": 0.2})), das, 1)
    assert np.mean(np.diff(held.impact_pressure) == 0.0) == pytest.approx(0.9, abs=0.01)


def test_latency_equals_that_of_the_data_system():
    das = data_system("50/50")
    by_effect = record(flown(EffectSpec("gps_latency", {"latency_s": 0.3}), gap=30.0), das, 1)
    by_system = record(flown(gap=30.0), replace(das, gps_latency=0.3), 1)
    for name in ("velocity_north", "velocity_east", "velocity_down", "altitude"):
        np.testing.assert_allclose(getattr(by_effect, name), getattr(by_system, name), atol=0.0102)


def test_a_gauge_reads_high_by_its_error():
    das = data_system("50/50")
    read = record(flown(EffectSpec("manifold_pressure_gauge", {"left_inhg": 1.0, "right_inhg": 0.0})), das, 1)
    plain = record(flown(), das, 1)
    np.testing.assert_allclose(
        read.manifold_pressure_left - plain.manifold_pressure_left, INCH_OF_MERCURY, atol=5.01
    )
    np.testing.assert_array_equal(read.manifold_pressure_right, plain.manifold_pressure_right)


def test_effects_on_the_aircraft_are_not_the_sensors_business_and_the_mass_is_that_of_the_weight_sheet():
    """The truth holds the load that an effect hides; the sheet, and so the log, does not."""
    das, truth = data_system("50/50"), flown()
    plain = record(truth, das, 1)
    assert differing(record(flown(EffectSpec("belly_pod", {"drag_area_m2": 0.1})), das, 1), plain) == set()
    hidden = flown(EffectSpec("mass", {"mass_kg": 150.0}))
    hidden = replace(hidden, channels={**hidden.channels, "mass": truth["mass"] + 150.0})
    assert differing(record(hidden, das, 1), plain) == set()
    assert hidden["mass"][0] == truth["mass"][0] + 150.0
