"""Long flights whose wind drifts far, and the mixture of models along its path."""

from dataclasses import replace

import numpy as np
from tests.calibration import static_flights as fixture
from tests.calibration.test_long_flights import CHECKED, HOUR, circling, correction_error

from pitotbench import CalibrationOptions
from pitotbench.calibration import calibrate


def test_a_wind_that_drifts_far_bends_nothing():
    """Ten times the drift: a problem linearized at its mean alone would be off by 1 m/s."""
    log = circling(wind=lambda t: (20.0 * t / HOUR, 15.0 * np.sin(2.0 * np.pi * t / HOUR)))
    curve = calibrate(log, CHECKED).curve
    assert np.all(correction_error(curve) <= 1.2 * curve.two_sigma)


def test_models_are_weighed_along_the_path_of_the_wind_too():
    """A wind that drifts, with and without a height, for the mixture of models as for one model."""
    for log in (circling(1900.0), fixture.fly("race_track", 2)):
        options = CalibrationOptions(
            model="auto", wind="checked" if log.altitude is None else "drifting"
        )
        found = calibrate(log, options).curve
        named = calibrate(log, replace(options, model="inverse+")).curve
        assert np.all(
            np.abs(found.correction - named.correction)
            <= np.hypot(found.two_sigma, named.two_sigma)
        )
