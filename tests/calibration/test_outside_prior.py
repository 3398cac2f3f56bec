"""What the log puts far outside what was assumed of it is said, by name and with its size."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.calibration import static_flights
from tests.calibration import trajectories as fixture

from pitotbench.calibration import calibrate
from pitotbench.calibration.covering import Posterior
from pitotbench.calibration.fit_checks import _nuisances_outside
from pitotbench.calibration.options import Accuracies, CalibrationOptions
from pitotbench.calibration.prediction import Nuisance
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.pressure_error.models import PressureErrorCurve

QUIET = fixture.Air(gust=0.05, pressure=2.0)


def _outside(result):
    return [warning for warning in result.warnings if "what was assumed" in warning]


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


def test_gusts_of_another_scale_are_named_with_their_length():
    """A wave of 300 s, some 20 km, where gusts of 533 m are expected."""
    log = fixture.fly(fixture.circles(10), 10, 10, fixture.Air(gust=0.0, pressure=2.0))
    slow = replace(log, velocity_north=log.velocity_north + 1.5 * np.sin(2.0 * np.pi * log.time / 300.0))
    result = calibrate(slow, CalibrationOptions(wind="constant"))
    assert any("gusts' length" in warning for warning in _outside(result)), result.diagnostics


@pytest.mark.parametrize("maneuver", ["circle", "step_decrease", "rapid_decel"])
def test_a_flight_as_assumed_warns_of_nothing(maneuver):
    assert not _outside(calibrate(static_flights.fly(maneuver, 3)))


def test_a_temperature_that_the_log_hardly_knows_is_named_all_the_same():
    """The prior of 0.75 K holds an error of 5 K down to some 1 K, which such a log would find in 1 % of cases."""
    usual = CalibrationOptions(accuracies=Accuracies(temperature_k=1.5))
    log = static_flights.fly("rapid_decel", 3, conditions=static_flights.Conditions(gust=0.3))
    off = replace(log, total_temperature=log.total_temperature + 5.0)
    (warning,) = _outside(calibrate(off, usual))
    assert "constant error of the temperature is found to be -1" in warning
    assert not _outside(calibrate(log, usual))


def test_estimates_scatter_as_the_prior_and_the_log_let_them():
    """One number with a prior of 1, seen by logs with errors of 3: estimates are 0.1 of it, scattered by √0.1."""
    structure = SimpleNamespace(nuisances=(Nuisance("temperature_k", 1.0, None),), model=SimpleNamespace(count=0))

    def said(seen, error):
        known = 1.0 / (1.0 + error**2)
        answer = Posterior(np.ones(1), np.array([[known * seen]]), np.array([[[1.0 - known]]]))
        return bool(_nuisances_outside(structure, answer))

    one_in_a_hundred = 2.576 * np.sqrt(10.0)
    for share in (1.01, -1.01):
        assert said(share * one_in_a_hundred, 3.0)
        assert not said(share * 0.98 * one_in_a_hundred, 3.0)
    assert said(9.0, 3.0)  # moves the estimate by less than its prior's deviation
    assert not said(90.0, 100.0)  # a log that says nothing
