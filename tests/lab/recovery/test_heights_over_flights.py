"""Models weighed with the height, over many flights."""

import numpy as np
import pytest
from tests.calibration import static_flights as fixture
from tests.calibration.test_altitude import STATIC, _error_kt

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


@pytest.mark.parametrize(
    ("maneuver", "expected"), [("rapid_decel", 0.64), ("step_decrease", 0.47), ("circle", 0.66)]
)
def test_the_height_narrows_the_bound_as_the_information_allows_and_it_still_covers(
    maneuver, expected
):
    """`expected`: the ratio for known covariances."""
    ratios, inside, size = [], [], []
    for seed in range(5, 13):
        log = fixture.fly(maneuver, seed)
        joint, alone = calibrate(log, STATIC), calibrate(fixture.without_height(log), STATIC)
        ratios.append(np.mean(joint.curve.two_sigma) / np.mean(alone.curve.two_sigma))
        inside.append(np.abs(_error_kt(joint)) <= joint.curve.two_sigma / KNOT)
        size.append(_error_kt(joint) / (joint.curve.two_sigma / KNOT))
    assert np.mean(ratios) == pytest.approx(expected, rel=0.15)
    assert np.mean(np.concatenate(inside)) >= 0.85
    assert 0.25 < np.sqrt(np.mean(np.concatenate(size) ** 2)) < 0.75  # 0.5 for a perfect 2σ
