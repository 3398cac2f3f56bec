"""Faulty rows are found, listed and do no harm; healthy rows stay."""

from dataclasses import replace

import numpy as np
from scipy.signal import lfilter
from tests.calibration import trajectories as fixture

from pitotbench import CalibrationOptions
from pitotbench.calibration import calibrate
from pitotbench.units import KNOT

RATE = 20


def _log(seed=1, gps_rate=RATE):
    return fixture.fly(fixture.step_decrease(RATE), RATE, gps_rate, fixture.Air(), seed)


def _with(log, rows, factor):
    impact = log.impact_pressure.copy()
    impact[rows] *= factor
    return replace(log, impact_pressure=impact)


def _difference(result, reference):
    one, other = result.curve, reference.curve
    at = other.indicated_airspeed
    return (
        np.max(np.abs(np.interp(at, one.indicated_airspeed, one.correction) - other.correction))
        / KNOT
    )


def test_healthy_rows_all_count_also_for_a_model_that_does_not_fit():
    for seed in range(1, 9):
        for gps_rate in (1, RATE):
            result = calibrate(_log(seed, gps_rate))
            assert result.diagnostics.rows_left_out == ()
    log = fixture.fly(fixture.step_decrease(RATE), RATE, RATE, fixture.Air(gust=0.0, pressure=1.0))
    for model in ("bias", "linear"):
        assert calibrate(log, CalibrationOptions(model=model)).diagnostics.rows_left_out == ()


def test_a_burst_of_gusts_is_no_fault_of_the_rows():
    """Gusts of 0.6 m/s that are four times as strong for some 8 s."""
    for seed in range(1, 7):
        log, rng = _log(seed), np.random.default_rng(seed)
        kept = float(np.exp(-1.0 / RATE / 5.0))  # 5 s
        gust = lfilter(
            [np.sqrt(1.0 - kept**2)], [1.0, -kept], rng.standard_normal((2, len(log))), axis=1
        )
        level = 0.4 * (1.0 + 3.0 * np.exp(-0.5 * ((log.time - 60.0) / 3.0) ** 2))
        carried = {"velocity_north": log.velocity_north + level * gust[0]}
        carried["velocity_east"] = log.velocity_east + level * gust[1]
        assert calibrate(replace(log, **carried)).diagnostics.rows_left_out == ()


def test_spikes_are_named_and_do_no_harm():
    log, rows = _log(), np.array([100, 777, 1500, 2600, 4000])
    result = calibrate(_with(log, rows, 3.0))
    assert result.diagnostics.rows_left_out == tuple(rows.tolist())
    assert any("5 rows disagree" in text and "5.00" in text for text in result.warnings)
    assert _difference(result, calibrate(log)) < 0.02
    kept = calibrate(_with(log, rows, 3.0), CalibrationOptions(robust=False))
    assert _difference(kept, calibrate(log)) > 0.05  # the trap


def test_a_dropout_of_seconds_and_a_wild_gps_fix_are_left_out():
    log, rows = _log(), np.arange(1200, 1300)
    result = calibrate(_with(log, rows, 0.5))
    found = set(result.diagnostics.rows_left_out)
    assert set(rows.tolist()) <= found
    assert len(found) <= 100 + 2 * RATE  # whole seconds at its ends
    assert _difference(result, calibrate(log)) < 0.1
    log = _log(gps_rate=1)
    north = log.velocity_north.copy()
    north[2000:2020] += 40.0
    result = calibrate(replace(log, velocity_north=north))
    assert set(range(2000, 2015)) <= set(result.diagnostics.rows_left_out)
    assert _difference(result, calibrate(log)) < 0.1
