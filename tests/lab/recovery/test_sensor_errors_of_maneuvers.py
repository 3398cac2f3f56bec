"""What errors of a maneuver's sensors do to the terms that are found."""

from dataclasses import replace

import numpy as np
from tests.lab.recovery.test_terms import _maneuver, _reconciled


def test_errors_of_the_sensors_are_no_weaker_airplane():
    """Errors of a measured rate make its damping seem smaller: so much of it is floor."""
    true = _maneuver(9)
    rates = true.motion.roll_rate
    error = 0.5 * float(np.std(rates))
    noisy = rates + np.random.default_rng(5).normal(0.0, error, len(rates))
    noise = {"roll_rate": error * 0.45}  # of the mean of five samples
    seen = replace(true, motion=replace(true.motion, roll_rate=noisy), noise=noise)
    (with_errors, without) = (
        _reconciled(each).logs[0].null.scores.left_over for each in (seen, replace(seen, noise={}))
    )
    assert with_errors["roll_damping|change"] > 3.0
    assert set(without.values()) == {1.0}
