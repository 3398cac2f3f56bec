"""Models weighed with the height, over many flights."""

import numpy as np
from tests.calibration import static_flights as fixture
from tests.calibration.test_altitude import _error_kt

from pitotbench import CalibrationOptions
from pitotbench.calibration import calibrate
from pitotbench.units import KNOT


def test_models_are_weighed_with_the_height_too():
    """The bound of one flight falls; over flights the curve is inside it."""
    options = CalibrationOptions(model="auto", error_location="static")
    inside = []
    for seed in range(5, 9):
        log = fixture.fly("circle", seed)
        joint = calibrate(log, options)
        inside.append(np.abs(_error_kt(joint)) <= joint.curve.two_sigma / KNOT)
    alone = calibrate(fixture.without_height(log), options)
    assert np.mean(joint.curve.two_sigma) < 0.85 * np.mean(alone.curve.two_sigma)
    # The points of one flight are right or wrong together, so that four flights scatter as four
    # trials do.
    assert np.mean(np.concatenate(inside)) >= 0.95 - 2.0 * np.sqrt(0.95 * 0.05 / len(inside))
