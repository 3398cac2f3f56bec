"""Several logs of one airplane: a curve in common, each its own wind."""

from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench.calibration import calibrate, calibrate_together
from pitotbench.calibration.options import Accuracies, CalibrationOptions

SEEDS = range(600, 612)


def _log(seed, rate=10):
    return fixture.fly(fixture.step_decrease(rate), rate, rate, fixture.Air(), seed)


def _other_wind(log, north, east):
    return replace(log, velocity_north=log.velocity_north + north, velocity_east=log.velocity_east + east)


def test_one_curve_each_its_wind_and_a_smaller_bound():
    first, second = _log(1), _other_wind(_log(2), 4.0, -3.0)
    alone, results, (single,) = calibrate(first), calibrate_together([first, second]), calibrate_together([first])
    np.testing.assert_array_equal(results[0].curve.correction, results[1].curve.correction)
    assert results[1].wind.north.value - results[0].wind.north.value == pytest.approx(4.0, abs=0.6)
    ratio = np.mean(results[0].curve.two_sigma) / np.mean(alone.curve.two_sigma)
    assert 0.5 < ratio < 0.9  # about 1/√2
    # One log together is the log alone.
    np.testing.assert_allclose(single.curve.correction, alone.curve.correction, atol=1e-9)
    assert np.mean(single.curve.two_sigma / alone.curve.two_sigma) == pytest.approx(1.0, abs=0.1)


def test_the_common_bound_covers():
    inside = []
    for seed in SEEDS:
        curve = calibrate_together([_log(seed), _other_wind(_log(seed + 100), 2.0, 5.0)])[0].curve
        inside.append(
            np.abs(curve.correction - fixture.true_correction(curve.indicated_airspeed)) <= curve.two_sigma
        )
    assert np.mean(np.concatenate(inside)) >= 0.88


def test_a_sensor_in_common_does_not_average_out():
    options = CalibrationOptions(accuracies=Accuracies(temperature_k=3.0))
    alone, pair = calibrate(_log(1), options), calibrate_together([_log(1), _log(2)], options)[0]
    assert pair.shares[0].curve == pytest.approx(alone.shares[0].curve, rel=0.05)


def test_logs_that_disagree_say_so():
    other = _log(2)
    bent = replace(other, impact_pressure=other.impact_pressure * np.linspace(1.05, 0.97, len(other)))
    results = calibrate_together([_log(1), bent])
    assert all(any("disagree about the curve" in text for text in result.warnings) for result in results)
    assert not any("disagree about" in text for text in calibrate_together([_log(1), other])[0].warnings)
