"""The bound that is meant to cover: over seeds of gusty air, dense and sparse GPS, on a path from formulas."""

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.units import KNOT

SEEDS = range(500, 512)


@pytest.mark.parametrize(("rate", "gps_rate", "gps_noise"), [(20, 1, 0.1), (20, 20, 0.05)])
def test_bound_covers_and_is_not_idle(rate, gps_rate, gps_noise):
    inside, wind_inside, squares, bounds = [], [], [], []
    for seed in SEEDS:
        noise = fixture.Air(gps=gps_noise)
        log = fixture.fly(fixture.step_decrease(rate), rate, gps_rate, noise, seed)
        result = calibrate(log)
        curve = result.curve
        error = curve.correction - fixture.true_correction(curve.indicated_airspeed)
        inside.append(np.abs(error) <= curve.two_sigma)
        squares.append(np.mean(error**2))
        bounds.append(np.mean(curve.two_sigma**2))
        for part, truth in zip((result.wind.north, result.wind.east), fixture.WIND, strict=True):
            wind_inside.append(abs(part.value - truth) <= part.two_sigma)
    assert np.mean(np.concatenate(inside)) >= 0.90
    assert np.mean(wind_inside) >= 0.90
    ratio = np.sqrt(np.mean(bounds) / np.mean(squares))  # a few flights with gusts of 10 km found would make it 5
    assert 1.5 < ratio < 3.5  # 2 for a perfect 2σ


@pytest.mark.parametrize(("rate", "gps_rate", "down"), [(20, 1, True), (50, 50, True), (20, 20, False)])
def test_recovers_the_curve_in_calm_air(rate, gps_rate, down):
    log = fixture.fly(fixture.step_decrease(rate), rate, gps_rate, fixture.Air(gust=0.0))
    curve = calibrate(log, CalibrationOptions(use_down=down)).curve
    error = curve.correction - fixture.true_correction(curve.indicated_airspeed)
    assert np.sqrt(np.mean(error**2)) <= 0.05 * KNOT


def test_more_gust_more_bound_and_the_same_log_the_same_answer():
    path = fixture.step_decrease(20)
    calm, rough, again = (calibrate(fixture.fly(path, 20, 20, fixture.Air(gust=g))) for g in (0.1, 0.6, 0.6))
    assert rough.curve.two_sigma.mean() > 2.0 * calm.curve.two_sigma.mean()
    np.testing.assert_array_equal(rough.curve.two_sigma, again.curve.two_sigma)
    assert rough.parameters == again.parameters
