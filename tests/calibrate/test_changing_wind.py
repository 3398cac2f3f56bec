"""`--wind checked`: a wind that changes is found and allowed for, a constant one stays constant."""

from dataclasses import replace

import numpy as np
import pytest
import static_flights as flights

from pitotbench.calibrate import CalibrationOptions, calibrate, calibrate_together
from pitotbench.units import KNOT

CHECKED, CONSTANT = CalibrationOptions(wind="checked"), CalibrationOptions(wind="constant")


def with_wind(log, change):
    """The same flight through the air, carried by a wind that changes: functions of time toward north and east."""
    north, east = change(log.time)
    fix = np.maximum.accumulate(np.where(log.gps_fresh, np.arange(len(log)), 0))  # held as the receiver's velocity
    return replace(log, velocity_north=log.velocity_north + north[fix], velocity_east=log.velocity_east + east[fix])


def front(middle, size):
    """A change of a size [m/s] toward east within 20 s."""
    return lambda time: (0.0 * time, size * np.clip((time - middle) / 20.0 + 0.5, 0.0, 1.0))


def steady(rate):
    """A change of a rate [m/s²] toward north."""
    return lambda time: (rate * (time - time.mean()), 0.0 * time)


def worst(result):
    """The largest error of the curve over its bound."""
    error = result.curve.correction - flights.true_correction(result.curve.indicated_airspeed)
    return float(np.max(np.abs(error) / result.curve.two_sigma))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_front_is_named_with_its_size_and_time(seed):
    log = with_wind(flights.fly("circle", seed), front(150.0, 4.0))
    found = calibrate(log, CHECKED)
    change = found.diagnostics["wind_change"]
    assert change["kind"] == "jump"
    assert change["size_mps"] == pytest.approx(4.0, abs=1.5)
    assert change["from_s"] - 20.0 < 150.0 < change["to_s"] + 20.0
    assert found.diagnostics["wind_probability"]["jump"] > 0.95
    assert any("the wind jumps by about" in warning for warning in found.warnings)


@pytest.mark.parametrize("maneuver", ["step_decrease", "rapid_decel", "circle"])
@pytest.mark.parametrize("change", [front(150.0, 3.0), steady(0.008)], ids=["front", "drift"])
def test_the_bound_holds_in_a_wind_that_changes(maneuver, change):
    log = with_wind(flights.fly(maneuver, 4), change)
    assert worst(calibrate(log, CHECKED)) < 1.5
    if maneuver == "circle":  # every heading at every speed: the change is found, and what is known is not lost
        assert (
            calibrate(log, CHECKED).curve.two_sigma.mean() < 0.8 * calibrate(log, CONSTANT).curve.two_sigma.mean()
        )


def test_in_calm_air_a_constant_wind_stays_constant_and_costs_nothing():
    log = flights.fly("circle", 1, conditions=flights.Conditions(gust=0.0))
    checked, constant = calibrate(log, CHECKED), calibrate(log, CONSTANT)
    assert checked.diagnostics["wind_probability"]["constant"] > 0.9
    np.testing.assert_allclose(checked.curve.two_sigma, constant.curve.two_sigma, rtol=0.05)
    assert not checked.warnings


def test_what_is_found_in_gusts_is_no_change():
    """Over seeds of gusts with a constant wind, a change is named in few."""
    named = ["wind_change" in calibrate(flights.fly("circle", seed), CHECKED).diagnostics for seed in range(20, 32)]
    assert sum(named) <= 1


def test_several_logs_each_have_a_wind_of_another_kind():
    """One log with a front, one without: a curve in common, and each log its wind."""
    quiet, changed = flights.fly("circle", 1), with_wind(flights.fly("circle", 2), front(150.0, 4.0))
    first, second = calibrate_together([quiet, changed], CHECKED)
    np.testing.assert_array_equal(first.curve.correction, second.curve.correction)
    assert any("the wind jumps" in warning for warning in second.warnings)
    assert worst(first) < 1.5


def test_models_are_weighed_in_the_wind_that_was_found():
    log = with_wind(flights.fly("circle", 3), front(150.0, 4.0))
    found = calibrate(log, CalibrationOptions(model="auto", wind="checked"))
    assert found.diagnostics["wind_change"]["kind"] == "jump"
    error = found.curve.correction - flights.true_correction(found.curve.indicated_airspeed)
    assert np.sqrt(np.mean(error**2)) < 0.5 * KNOT
