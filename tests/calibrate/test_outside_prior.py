"""What the log puts far outside what was assumed of it is said, by name and with its size."""

from dataclasses import replace

import numpy as np
import pytest
import static_flights
import trajectories as fixture

from pitotbench.calibrate import Accuracies, CalibrationOptions, calibrate
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE, PressureErrorCurve

QUIET = fixture.Air(gust=0.05, pressure=2.0)


def _outside(result):
    return [warning for warning in result.warnings if "standard deviations of what was assumed" in warning]


def test_a_zero_offset_beyond_its_accuracy_is_named_with_its_size():
    truth = PressureErrorCurve(MODELS["bias"], (-0.03,), REFERENCE_PRESSURE)
    log = fixture.fly(fixture.circles(20), 20, 20, QUIET, truth=truth)
    off = replace(log, impact_pressure=log.impact_pressure + 200.0)
    few = CalibrationOptions(model="bias", accuracies=Accuracies(impact_pressure_zero_pa=40.0))
    (warning,) = _outside(calibrate(off, few))
    assert "zero offset of the impact pressure" in warning
    assert "(±40 Pa, 2σ)" in warning
    enough = CalibrationOptions(model="bias", accuracies=Accuracies(impact_pressure_zero_pa=400.0))
    assert not _outside(calibrate(off, enough))


def test_a_vane_beyond_its_prior_is_named_with_its_size():
    log = fixture.fly(fixture.step_decrease(20), 20, 20, QUIET)
    off = replace(log, sideslip=np.full(len(log), np.deg2rad(25.0)))
    (warning,) = _outside(calibrate(off, CalibrationOptions(form="vector")))
    assert "sideslip vane" in warning
    assert "found to be -24" in warning  # the prior of 5° takes a little off


def test_gusts_of_another_scale_are_named_with_their_length():
    """A wave of 300 s, some 20 km, where gusts of 533 m are expected."""
    log = fixture.fly(fixture.circles(10), 10, 10, fixture.Air(gust=0.0, pressure=2.0))
    wave = 1.5 * np.sin(2.0 * np.pi * log.time / 300.0)
    slow = replace(log, velocity_north=log.velocity_north + wave)
    result = calibrate(slow, CalibrationOptions(wind="constant"))
    assert any("gusts' length" in warning for warning in _outside(result)), result.diagnostics


@pytest.mark.parametrize("maneuver", ["circle", "step_decrease", "rapid_decel"])
def test_a_flight_as_assumed_warns_of_nothing(maneuver):
    assert not _outside(calibrate(static_flights.fly(maneuver, 3)))
