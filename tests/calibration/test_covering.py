"""The bound that is meant to cover, over seeds of gusty air: of one log, and of several with a
curve in common.
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench.calibration import calibrate, calibrate_flights
from pitotbench.calibration.options import Accuracies, CalibrationOptions
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
    ratio = np.sqrt(
        np.mean(bounds) / np.mean(squares)
    )  # a few flights with gusts of 10 km found would make it 5
    assert 1.5 < ratio < 3.5  # 2 for a perfect 2σ


@pytest.mark.parametrize(
    ("rate", "gps_rate", "down"), [(20, 1, True), (50, 50, True), (20, 20, False)]
)
def test_recovers_the_curve_in_calm_air(rate, gps_rate, down):
    log = fixture.fly(fixture.step_decrease(rate), rate, gps_rate, fixture.Air(gust=0.0))
    curve = calibrate(log, CalibrationOptions(use_down=down)).curve
    error = curve.correction - fixture.true_correction(curve.indicated_airspeed)
    assert np.sqrt(np.mean(error**2)) <= 0.05 * KNOT


def test_more_gust_more_bound_and_the_same_log_the_same_answer():
    path = fixture.step_decrease(20)
    calm, rough, again = (
        calibrate(fixture.fly(path, 20, 20, fixture.Air(gust=g))) for g in (0.1, 0.6, 0.6)
    )
    assert rough.curve.two_sigma.mean() > 2.0 * calm.curve.two_sigma.mean()
    np.testing.assert_array_equal(rough.curve.two_sigma, again.curve.two_sigma)
    assert rough.parameters == again.parameters


PAIRS = range(600, 612)


def together(logs, options=None):
    return [each.calibration for each in calibrate_flights(logs, options)]


def _log(seed, rate=10):
    return fixture.fly(fixture.step_decrease(rate), rate, rate, fixture.Air(), seed)


def _other_wind(log, north, east):
    return replace(
        log, velocity_north=log.velocity_north + north, velocity_east=log.velocity_east + east
    )


def test_one_curve_each_its_wind_and_a_smaller_bound():
    first, second = _log(1), _other_wind(_log(2), 4.0, -3.0)
    alone, results, (single,) = (
        calibrate(first),
        together([first, second]),
        together([first]),
    )
    np.testing.assert_array_equal(results[0].curve.correction, results[1].curve.correction)
    assert results[1].wind.north.value - results[0].wind.north.value == pytest.approx(4.0, abs=0.6)
    ratio = np.mean(results[0].curve.two_sigma) / np.mean(alone.curve.two_sigma)
    assert 0.5 < ratio < 0.9  # about 1/√2
    # One log together is the log alone.
    np.testing.assert_allclose(single.curve.correction, alone.curve.correction, atol=1e-9)
    assert np.mean(single.curve.two_sigma / alone.curve.two_sigma) == pytest.approx(1.0, abs=0.1)


def test_the_common_bound_covers():
    inside = []
    for seed in PAIRS:
        curve = together([_log(seed), _other_wind(_log(seed + 100), 2.0, 5.0)])[0].curve
        inside.append(
            np.abs(curve.correction - fixture.true_correction(curve.indicated_airspeed))
            <= curve.two_sigma
        )
    assert np.mean(np.concatenate(inside)) >= 0.88


def test_a_sensor_in_common_does_not_average_out():
    options = CalibrationOptions(accuracies=Accuracies(temperature_k=3.0))
    alone, pair = calibrate(_log(1), options), together([_log(1), _log(2)], options)[0]
    assert pair.shares[0].curve == pytest.approx(alone.shares[0].curve, rel=0.05)


def test_logs_that_disagree_say_so():
    other = _log(2)
    bent = replace(
        other, impact_pressure=other.impact_pressure * np.linspace(1.05, 0.97, len(other))
    )
    results = together([_log(1), bent])
    assert all(
        any("disagree about the curve" in text for text in result.warnings) for result in results
    )
    assert not any("disagree about" in text for text in together([_log(1), other])[0].warnings)
