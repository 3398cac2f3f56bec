"""The altitude equation: exact without noise, inside its bound with noise, silent for a right
static pressure.
"""

import re
from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import static_flights as fixture

from pitotbench import Calibration, CalibrationOptions, FlightLog, air
from pitotbench.calibration import calibrate
from pitotbench.calibration.altitude import AltitudeNoise, altitude_regression, altitude_rows
from pitotbench.calibration.nuisances import ZERO, Nuisance
from pitotbench.calibration.observations import observe
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.show.calibration_json import calibration_json
from pitotbench.units import FOOT, KNOT

STATIC = CalibrationOptions(error_location="static")
SYNTHETIC = {
    "format": "pitotbench flight log 1",
    "accuracy": fixture.EXACT,
    "priors": fixture.COLUMNS,
}
MODEL = PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE, static_error=True)
THETA = np.array([*fixture.CURVE, *fixture.WIND])


def _error_kt(result: Calibration) -> np.ndarray:
    curve = result.curve
    return (curve.correction - fixture.true_correction(curve.indicated_airspeed)) / KNOT


def _rows_of(log: FlightLog, options: CalibrationOptions = STATIC, total_source: float = 0.0):
    obs = observe(log, options)
    options = replace(options, accuracies={"total_source": 2.0 * total_source})
    return altitude_rows(log, obs, options, np.array(fixture.WIND))


@pytest.mark.parametrize("down", [True, False])
@pytest.mark.parametrize("maneuver", ["step_decrease", "circle"])
def test_a_flight_without_noise_is_recovered_and_the_truth_leaves_nothing_of_the_rows(
    maneuver, down
):
    log = fixture.fly(maneuver, 1, replace(fixture.PERFECT, down=down), fixture.CALM)
    assert np.max(np.abs(_error_kt(calibrate(log, STATIC)))) < 0.005
    rows = _rows_of(log)
    left = altitude_regression(rows, MODEL, THETA, ()).response[: len(rows)]
    free = np.stack(
        [rows.state.gain, rows.state.temperature_slope], axis=1
    )  # the reference pressure, and the air's unknown humidity
    left = left - free @ np.linalg.lstsq(free, left)[0]
    assert np.ptp(rows.rise) > 3.0
    assert np.max(np.abs(left)) < 0.02  # m


def test_a_reading_stands_in_the_rows_and_not_in_their_columns():
    """A flat reference pressure would otherwise explain the noise of hours of rows."""
    log = fixture.fly("step_decrease")
    noisy = np.random.default_rng(1).normal(0.0, 20.0, len(log))
    shaken = replace(log, static_pressure=log.static_pressure + noisy)
    rows = [_rows_of(each) for each in (log, shaken)]
    assert np.std(rows[1].rise - rows[0].rise) > 0.1  # m
    flat = rows[0].unknown.precision == 0.0
    assert np.count_nonzero(flat) == 1
    before, after = (each.unknown.columns[: len(each), flat] for each in rows)
    assert np.std(after / before) < 1e-9


def test_what_the_total_source_may_do_is_no_news_of_the_static_source():
    """Heights that know nothing of the total source cannot tell a level or a slope in ln q_ci."""
    log, phi = fixture.fly("step_decrease"), np.log([0.5, 60.0, 0.05])
    known, unknown = (_rows_of(log, total_source=share) for share in (0.0, 1e3))
    meters = known.state.gain * known.state.impact_pressure
    slope = meters * np.log(np.maximum(known.state.impact_pressure, 1.0))
    columns = np.pad(np.stack([meters, slope], 1), ((0, known.count - len(known)), (0, 0)))
    told = [
        np.diag(columns.T @ AltitudeNoise(rows)(phi).weigh(columns)) for rows in (known, unknown)
    ]
    assert np.all(told[1] < 1e-3 * told[0])


def test_a_doubtful_total_source_widens_what_the_height_tells():
    log = fixture.fly("step_decrease", 3)
    bounds = [
        calibrate(log, replace(STATIC, accuracies={"total_source": share})).curve.two_sigma.mean()
        for share in (0.0, 0.014, 0.1)
    ]
    assert bounds[0] < bounds[1] < bounds[2]


def test_the_rows_move_with_the_curve_as_their_regressors_say():
    rows = _rows_of(fixture.fly("circle"))
    plain = altitude_regression(rows, MODEL, THETA, ())
    for place in range(MODEL.count):
        step = np.zeros(MODEL.count)
        step[place] = 1e-6
        ahead = altitude_regression(rows, MODEL, THETA + step, ()).response
        behind = altitude_regression(rows, MODEL, THETA - step, ()).response
        expected = -(ahead - behind) / 2e-6
        np.testing.assert_allclose(plain.regressors[:, place], expected, atol=1e-5)


def test_the_rows_move_with_the_zero_offset_as_their_regressor_says():
    """The ports see the reading minus the offset; the rows at rest see nothing."""
    rows = _rows_of(fixture.after_rest(fixture.fly("circle"), 60.0))
    offset = Nuisance(ZERO, 200.0, lambda prediction, obs: np.zeros(0))
    found = altitude_regression(rows, MODEL, THETA, (offset,)).regressors[: len(rows), MODEL.count]
    at_rest = rows.state.impact_pressure == 0.0
    moved_by = {
        step: np.where(at_rest, 0.0, rows.state.impact_pressure + step) for step in (-1.0, 1.0)
    }
    less, more = (
        replace(rows, state=replace(rows.state, impact_pressure=q)) for q in moved_by.values()
    )
    moved = [
        altitude_regression(each, MODEL, THETA, ()).response[: len(rows)] for each in (less, more)
    ]
    np.testing.assert_allclose(found, 0.5 * (moved[1] - moved[0]), atol=1e-6)
    assert at_rest.any()
    assert not found[at_rest].any()


@pytest.mark.parametrize("maneuver", ["rapid_decel", "circle"])
def test_the_place_of_the_error_is_found(maneuver):
    found = calibrate(fixture.fly(maneuver, 5))
    assert found.error_location == "static"
    assert found.diagnostics.static_probability > 0.99
    log = fixture.fly(maneuver, 5, conditions=fixture.Conditions(location="impact"))
    assert calibrate(log).error_location == "total"
    named = calibrate(replace(log, header=SYNTHETIC))
    assert named.error_location == "impact"
    assert named.curve.altitude_correction is None


def test_what_a_probe_5_k_off_would_do_is_said_and_is_what_it_does():
    log = replace(fixture.fly("race_track", 5), header={})
    off = replace(log, total_temperature=log.total_temperature + 5.0)
    right, wrong = (calibrate(each, STATIC) for each in (log, off))
    assert wrong.day.departure - right.day.departure == pytest.approx(5.0, abs=0.2)
    moved = float(np.sqrt(np.mean((wrong.curve.correction - right.curve.correction) ** 2)))
    assert right.day.by_five_kelvin == pytest.approx(moved, rel=0.3)
    said = calibration_json(right)["temperature"]
    assert said["five_kelvin_kt"] == pytest.approx(right.day.by_five_kelvin / KNOT)
    assert calibrate(replace(log, header={"accuracy": fixture.EXACT}), STATIC).day is None


def test_where_the_static_pressure_is_right_the_height_changes_nothing():
    log = fixture.fly("circle", 5, conditions=fixture.Conditions(location="impact"))
    for location in ("impact", "total"):
        options = CalibrationOptions(error_location=location)
        with_height, without = (
            calibrate(log, options),
            calibrate(fixture.without_height(log), options),
        )
        np.testing.assert_array_equal(with_height.curve.correction, without.curve.correction)
        np.testing.assert_array_equal(with_height.curve.two_sigma, without.curve.two_sigma)


def test_without_height_a_measured_log_is_static_and_its_bound_holds_the_other_place():
    log = fixture.without_height(fixture.fly("circle", 5))
    result = calibrate(log)
    static, impact = (
        calibrate(log, CalibrationOptions(error_location=place)) for place in ("static", "impact")
    )
    assert result.error_location == "static"
    np.testing.assert_allclose(result.curve.correction, static.curve.correction, atol=1e-3 * KNOT)
    apart = static.curve.correction - impact.curve.correction
    expected = np.hypot(static.curve.two_sigma, 2.0 * apart)
    np.testing.assert_allclose(result.curve.two_sigma, expected, rtol=0.02)


def test_without_height_a_synthetic_log_has_the_published_place():
    log = replace(fixture.without_height(fixture.fly("circle", 5)), header=SYNTHETIC)
    result = calibrate(log)
    assert result.error_location == "impact"
    np.testing.assert_array_equal(
        result.curve.two_sigma,
        calibrate(log, CalibrationOptions(error_location="impact")).curve.two_sigma,
    )


def test_the_altitude_correction_holds_the_truth():
    """Where Δp is positive the static source reads too high, and the airplane is higher than it
    reads.
    """
    inside = []
    for seed in range(5, 13):
        curve = calibrate(fixture.fly("circle", seed)).curve
        error = fixture.true_error(air.impact_pressure(curve.indicated_airspeed))
        true = error / (1.0225 * air.GRAVITY)  # m; density at 6,000 ft of a standard day
        inside.append(np.abs(curve.altitude_correction - true) <= curve.altitude_two_sigma)
        assert np.ptp(true) > 3.0 * np.max(curve.altitude_two_sigma)
        assert np.max(curve.altitude_two_sigma) < 15.0 * FOOT
    assert np.mean(np.concatenate(inside)) >= 0.85


def test_rows_at_rest_fix_the_reference_pressure():
    """With the pressure known where the error is zero, the level of the curve is seen, not only its
    shape.
    """
    plain = fixture.fly("rapid_decel", 5)
    rested = fixture.after_rest(plain, 120.0)
    without, with_rest = (
        calibrate(plain, STATIC).curve.two_sigma,
        calibrate(rested, replace(STATIC, accuracies={"total_source": 0.0})).curve.two_sigma,
    )
    assert np.mean(with_rest) < 0.95 * np.mean(without)
    assert np.all(np.abs(_error_kt(calibrate(rested, STATIC))) < 1.5 * with_rest / KNOT)


def test_spikes_of_height_and_of_static_pressure_do_not_matter():
    log = fixture.fly("circle", 5)
    static, altitude = log.static_pressure.copy(), log.altitude.copy()
    static[500::997] += 3000.0
    altitude[2000:2020] = 0.0
    spoiled = calibrate(replace(log, static_pressure=static, altitude=altitude), STATIC).curve
    np.testing.assert_allclose(
        spoiled.correction, calibrate(log, STATIC).curve.correction, atol=0.1 * KNOT
    )


def test_a_zero_error_of_the_vertical_velocity_is_held_by_the_receivers_height():
    """The integral of a velocity that is 0.3 m/s off leaves the height by 100 m; without the fixes
    the bound would be four times as wide.
    """
    log = fixture.fly("step_decrease", 5)
    drifting = calibrate(replace(log, velocity_down=log.velocity_down + 0.3), STATIC)
    plain = calibrate(log, STATIC).curve.two_sigma
    assert np.mean(drifting.curve.two_sigma) < 2.0 * np.mean(plain)
    assert np.all(np.abs(_error_kt(drifting)) < 1.5 * drifting.curve.two_sigma / KNOT)


def test_a_static_pressure_that_contradicts_the_triangle_is_told_and_held():
    """Where the static pressure has an error that the impact pressure does not share, no one curve
    fits both.
    """
    log = fixture.fly("circle", 300)
    assert not calibrate(log, STATIC).disagreements
    wrong = replace(log, static_pressure=log.static_pressure + 0.05 * log.impact_pressure)
    both, triangle = (calibrate(wrong, replace(STATIC, use_altitude=use)) for use in (True, False))
    assert [each.kind for each in both.disagreements] == ["height"]
    assert both.usable
    without = re.search(r"at (\d+) KIAS from ([-+.\d]+) to", both.disagreements[0].words)
    speed, curve = float(without[1]) * KNOT, triangle.curve
    alone = np.interp(speed, curve.indicated_airspeed, curve.correction) / KNOT
    assert float(without[2]) == pytest.approx(alone, abs=0.15), "the curve without the height"
    apart = np.abs(both.curve.correction - triangle.curve.correction)
    assert np.all(apart < both.curve.two_sigma), "the bound holds the answer of the triangle too"
    told = re.search(r"from ([-+.\d]+) to ([-+.\d]+) kt", both.disagreements[0].words).groups()
    at = np.interp(speed, curve.indicated_airspeed, both.curve.correction) / KNOT
    bound = np.interp(speed, curve.indicated_airspeed, both.curve.two_sigma) / KNOT
    assert all(abs(float(each) - at) < bound for each in told), "the bound holds both that are told"
