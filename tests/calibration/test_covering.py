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


@pytest.mark.parametrize("rates", [(20, 1), (50, 50)])
def test_recovers_the_curve_in_calm_air(rates):
    log = fixture.fly(fixture.step_decrease(rates[0]), *rates, fixture.Air(gust=0.0))
    curve = calibrate(log).curve
    error = curve.correction - fixture.true_correction(curve.indicated_airspeed)
    assert np.sqrt(np.mean(error**2)) <= 0.05 * KNOT


def test_same_log_same_answer():
    log = fixture.fly(fixture.step_decrease(20), 20, 1, fixture.Air())
    first, second = calibrate(log), calibrate(log)
    np.testing.assert_array_equal(first.curve.two_sigma, second.curve.two_sigma)
    assert first.parameters == second.parameters


def test_more_gust_more_bound():
    path = fixture.step_decrease(20)
    calm, rough = (
        calibrate(fixture.fly(path, 20, 20, fixture.Air(gust=g))).curve.two_sigma.mean() for g in (0.1, 0.6)
    )
    assert rough > 2.0 * calm


def test_without_vertical_velocity_the_fit_still_runs():
    log = fixture.fly(fixture.step_decrease(20), 20, 20, fixture.Air())
    result = calibrate(log, CalibrationOptions(use_down=False))
    assert np.all(np.isfinite(result.curve.two_sigma))
