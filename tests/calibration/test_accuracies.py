"""What a log does not tell: stated accuracies widen the bound by their share; errors within them
are covered.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import BadInputError, CalibrationOptions, NoAnswerError, air
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import (
    USUAL,
    Accuracies,
    accuracies_of,
    assumptions_of,
    parse_accuracies,
)
from pitotbench.calibration.prediction import CurveMap, PredictionModel
from pitotbench.estimation.mixture import Posterior
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.pressure_error.models import PressureErrorCurve
from pitotbench.records import USUAL_ACCURACIES
from pitotbench.show.calibration_json import calibration_json
from pitotbench.show.columns import json_text
from pitotbench.units import KNOT

QUIET = fixture.Air(gust=0.05, pressure=2.0)


@pytest.fixture(scope="module")
def log():
    return fixture.fly(fixture.step_decrease(20), 20, 20, QUIET)


def _error(result):
    return result.curve.correction - fixture.true_correction(result.curve.indicated_airspeed)


def test_a_temperature_error_is_invisible_and_covered_by_its_stated_accuracy(log):
    warm = replace(log, total_temperature=log.total_temperature + 2.0)
    plain = calibrate(warm)
    stated = calibrate(warm, CalibrationOptions(accuracies=Accuracies(temperature_k=3.0)))
    assert plain.residual_two_sigma == pytest.approx(calibrate(log).residual_two_sigma, rel=0.02)
    assert np.all(np.abs(_error(plain)) > plain.curve.two_sigma)  # the trap
    assert np.all(np.abs(_error(stated)) < stated.curve.two_sigma)


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("temperature_k", 2.0),
        ("recovery_factor", 0.1),
        ("static_pressure_pa", 100.0),
        ("velocity_mps", 0.2),
    ],
)
def test_shares_add_to_the_bound_as_squares(log, name, size):
    without = calibrate(log)
    result = calibrate(log, CalibrationOptions(accuracies=Accuracies(**{name: size})))
    assert all(share.name.startswith(name.rsplit("_", 1)[0]) for share in result.shares)
    for seen, before, parts in (
        (result.curve.two_sigma, without.curve.two_sigma, [s.curve for s in result.shares]),
        (
            result.wind.north.two_sigma,
            without.wind.north.two_sigma,
            [s.wind for s in result.shares],
        ),
    ):
        added = np.sqrt(max(np.mean(np.square(seen)) - np.mean(np.square(before)), 0.0))
        assert added == pytest.approx(np.max(parts), rel=0.1, abs=0.05 * KNOT)


def test_no_part_of_a_bound_exceeds_the_whole():
    """A mixture with a wide and rare component has a half-width below twice its standard deviation."""
    weights, covariances = np.array([0.97, 0.03]), np.array([1.0, 400.0])[:, None, None] * np.eye(2)
    answer = Posterior(weights, np.zeros((2, 2)), covariances)
    along = np.array([[1.0, 0.0], [0.6, 0.8]])
    bounds = answer.two_sigma(along)
    assert bounds[0] < 2.0 * np.sqrt(answer.covariance[0, 0])
    np.testing.assert_allclose(
        answer.two_sigma_by(0, along, bounds), [1.0, 0.6] * bounds, rtol=1e-12
    )


def test_sensitivity_to_temperature_is_the_known_one(log):
    """Half a percent of airspeed for a percent of temperature."""
    result = calibrate(log, CalibrationOptions(accuracies=Accuracies(temperature_k=1.0)))
    indicated = result.curve.indicated_airspeed
    assert result.shares[0].curve == pytest.approx(
        0.5 / 276.3 * np.sqrt(np.mean(indicated**2)), rel=0.1
    )


def test_the_usual_accuracies_hold_where_nobody_states_one(log):
    """Of a log that says nothing of its sensors the bound allows for a probe that is 1.5 K off."""
    warm = replace(log, total_temperature=log.total_temperature + 1.5)
    exact, usual = (
        calibrate(log),
        calibrate(replace(log, header={name: log.header[name] for name in ("format", "priors")})),
    )
    moved = np.abs(calibrate(warm).curve.correction - exact.curve.correction)
    widened = np.sqrt(usual.curve.two_sigma**2 - exact.curve.two_sigma**2)
    assert np.all(moved > 0.1)  # m/s
    assert np.all(widened > 0.95 * moved)
    assert {(a.name, a.two_sigma) for a in usual.assumptions} == set(USUAL_ACCURACIES.items())
    assert {a.source for a in usual.assumptions} == {"usual"}
    assert all(a.two_sigma == 0.0 and a.source == "header" for a in exact.assumptions)


def test_each_accuracy_comes_from_the_user_before_the_header_before_the_usual():
    found = assumptions_of(
        {"temperature_k": 5.0}, {"accuracy": {"temperature_k": 2.0, "static_pressure_pa": 80.0}}
    )
    by_name = {a.name: (a.two_sigma, a.source) for a in found}
    assert by_name["temperature_k"] == (5.0, "stated")
    assert by_name["static_pressure_pa"] == (80.0, "header")
    assert by_name["recovery_factor"] == (USUAL.recovery_factor, "usual")


def test_none_turns_all_accuracies_off_but_those_named_beside_it():
    assert parse_accuracies("temperature_k=1, recovery_factor=0.1") == {
        "temperature_k": 1.0,
        "recovery_factor": 0.1,
    }
    header = {"accuracy": {"temperature_k": 2.0}}
    assert accuracies_of(parse_accuracies("none"), header) == Accuracies()
    some = accuracies_of(parse_accuracies("none, impact_pressure_zero_pa=400"), header)
    assert some == Accuracies(impact_pressure_zero_pa=400.0)


def test_the_published_method_takes_its_sensors_for_exact(log):
    result = calibrate(replace(log, header={}), CalibrationOptions(method="paper"))
    assert {(a.two_sigma, a.source) for a in result.assumptions} == {(0.0, "method")}


@pytest.mark.parametrize("model", ["bias", "linear", "auto"])
def test_the_correction_of_a_sensor_with_a_zero_offset_is_for_its_raw_reading(model):
    """A slow airplane: 60 Pa of zero offset are half of its impact pressure at 28 kt."""
    truth = PressureErrorCurve(MODELS["bias"], (-0.03,), REFERENCE_PRESSURE)
    path = fixture.circles(20, speeds_kt=(28, 32, 36, 40))
    log = fixture.fly(path, 20, 20, fixture.Air(gust=0.1, pressure=2.0), truth=truth)
    raw = replace(log, impact_pressure=log.impact_pressure + 60.0)
    result = calibrate(
        raw, CalibrationOptions(model=model, accuracies={"impact_pressure_zero_pa": 400.0})
    )
    curve = result.curve
    impact = truth.impact_pressure(air.impact_pressure(curve.indicated_airspeed) - 60.0)
    expected = air.calibrated_airspeed(impact) - curve.indicated_airspeed
    assert np.min(expected) < -4.0 * KNOT
    assert np.all(np.abs(curve.correction - expected) < curve.simultaneous_two_sigma)
    assert np.max(curve.two_sigma) < 2.0 * KNOT
    assert abs(result.impact_pressure_zero.value - 60.0) < result.impact_pressure_zero.two_sigma


def test_the_gradient_of_the_correction_by_a_zero_offset_is_that_of_differences():
    model = PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE)
    speeds, k = np.array([40.0, 60.0, 90.0]) * KNOT, np.array([-0.06, 0.006, 0.03])
    ahead, behind = (CurveMap(model, speeds, 50.0 + step).correction(k) for step in (0.01, -0.01))
    given = CurveMap(model, speeds, 50.0).correction_by_zero(k)
    np.testing.assert_allclose(given, (ahead - behind) / 0.02, rtol=1e-6)


def test_no_temperature_means_a_wide_prior(log):
    result = calibrate(replace(log, total_temperature=None))
    assert (result.assumptions[0].two_sigma, result.assumptions[0].source) == (15.0, "standard day")
    assert [s.name for s in result.shares] == ["temperature_k"]
    assert result.shares[0].curve > 1.0 * KNOT
    assert any("temperature" in warning for warning in result.warnings)


def test_what_an_unknown_temperature_costs_is_computed_and_told(log):
    """Its share of the bound is what vanishes with a thermometer."""
    without = calibrate(replace(log, total_temperature=None))
    known = calibrate(log, CalibrationOptions(accuracies={"temperature_k": 0.0}))
    whole, rest = (float(np.sqrt(np.mean(r.curve.two_sigma**2))) for r in (without, known))
    share = without.shares[0].curve
    assert np.hypot(share, rest) == pytest.approx(whole, rel=0.1)
    (told,) = (warning for warning in without.warnings if warning.code == "standard day")
    assert f"±{share / KNOT:.1f} kt to the curve's ±{whole / KNOT:.1f} kt" in told


def test_the_published_method_takes_the_standard_day_for_exact(log):
    """Its bound has no share of the temperature: none is told, and no range of the day."""
    found = calibrate(replace(log, total_temperature=None), CalibrationOptions(method="paper"))
    (told,) = (warning for warning in found.warnings if warning.code == "standard day")
    assert "taken for exact" in told
    assert "K (2σ)" not in told


@pytest.mark.parametrize("wind", ["linear", "drifting"])
def test_a_wind_that_changes_widens_the_bound_and_is_covered(wind):
    log = fixture.fly(fixture.step_decrease(20), 20, 20, fixture.Air(gust=0.15))
    elapsed = (log.time - log.time.mean()) / np.ptp(log.time)
    log = replace(log, velocity_north=log.velocity_north + elapsed)  # by 1 m/s over the log
    constant, honest = calibrate(log), calibrate(log, CalibrationOptions(wind=wind))
    assert np.max(np.abs(_error(constant)) / constant.curve.two_sigma) > 1.0  # the trap
    assert np.all(np.abs(_error(honest)) < honest.curve.two_sigma)
    assert np.mean(honest.curve.two_sigma) > 1.2 * np.mean(constant.curve.two_sigma)


@pytest.mark.parametrize("latency", ["checked", "estimated"])
def test_a_latency_is_found_where_the_speed_changes_and_taken_out(latency):
    log = _decelerations(latency=0.5)
    found = calibrate(log, CalibrationOptions(latency=latency))
    assert found.diagnostics.latency.value == pytest.approx(0.5, abs=0.15)
    assert found.diagnostics.latency.two_sigma < 0.15
    assert [s.name for s in found.shares] == ["latency_s"]
    assert np.max(np.abs(_error(found))) < 0.12
    given = calibrate(log)
    assert given.diagnostics.latency is None
    assert np.mean(found.curve.two_sigma) < 0.3 * np.mean(given.curve.two_sigma)


def test_a_stated_latency_is_fixed_and_what_is_left_of_it_is_none():
    log = _decelerations(latency=0.5)
    left = calibrate(log, CalibrationOptions(gps_latency=0.5, latency="checked"))
    assert left.diagnostics.latency.value == pytest.approx(0.5, abs=0.15)
    fixed = calibrate(log, CalibrationOptions(gps_latency=0.5))
    assert fixed.shares == ()
    assert fixed.diagnostics.latency is None
    assert np.max(np.abs(_error(fixed))) < 0.12


def test_a_latency_is_found_beside_a_linear_wind_in_the_rows_that_count():
    log = _decelerations(latency=0.5)
    spoiled = log.impact_pressure.copy()
    spoiled[1000:1010] += 3000.0
    options = CalibrationOptions(wind="linear", latency="checked")
    result = calibrate(replace(log, impact_pressure=spoiled), options)
    clean = calibrate(log, options)
    assert len(result.diagnostics.rows_left_out) >= 10
    assert result.diagnostics.latency.value == pytest.approx(
        clean.diagnostics.latency.value, abs=0.05
    )


def test_a_latency_that_the_log_does_not_show_has_no_bound_and_no_estimate():
    still = fixture.fly(fixture.circles(20, (130, 130, 130)), 20, 20, QUIET)
    result = calibrate(still, CalibrationOptions(model="bias", latency="checked"))
    assert np.isinf(result.diagnostics.latency.two_sigma)
    assert (
        json.loads(json_text(calibration_json(result)))["diagnostics"]["latency_two_sigma_s"]
        is None
    )
    with pytest.raises(NoAnswerError, match="idle deceleration"):
        calibrate(still, CalibrationOptions(model="bias", latency="estimated"))


def _decelerations(latency):
    """Decelerations and accelerations of 2 kt/s on four headings, the GPS stamped late."""
    rate, headings = 20, (0.0, 90.0, 180.0, 270.0)
    leg = np.concatenate([np.linspace(160, 100, 30 * rate), np.linspace(100, 160, 30 * rate)])
    speed, heading = np.tile(leg, len(headings)), np.repeat(np.deg2rad(headings), len(leg))
    log = fixture.fly((speed * KNOT, heading), rate, rate, fixture.Air(gust=0.1))
    late = {
        name: np.interp(log.time - latency, log.time, getattr(log, name))
        for name in ("velocity_north", "velocity_east")
    }
    beside_turns = (
        np.abs((log.time + 30.0) % 60.0 - 30.0) > 5.0
    )  # the turns between the legs are not flown
    return replace(log, **late, gps_fresh=np.ones(len(log), dtype=bool)).select(beside_turns)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("temperature=1", "Did you mean 'temperature_k'"),
        ("temperature_k", "name=2σ"),
        ("temperature_k=x", "name=2σ"),
        ("temperature_k=-1", "zero or more"),
        ("temperature_k=nan", "zero or more"),
    ],
)
def test_wrong_accuracies_are_refused(text, says):
    with pytest.raises(BadInputError, match=says):
        parse_accuracies(text)
