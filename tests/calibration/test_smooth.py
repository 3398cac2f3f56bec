"""The smooth curve: it covers curves that no law draws, costs little where a law holds, and says
which size of departure the log supports.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import (
    BadInputError,
    CalibrationOptions,
    Case,
    UnknownNameError,
    fly,
    sense,
    write_log,
)
from pitotbench.calibration import calibrate, calibrate_flights
from pitotbench.calibration.covering_problem import Structure, log_prior_of
from pitotbench.calibration.observations import observe
from pitotbench.calibration.options import PRIORS
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.campaigns.flights import compare_curve
from pitotbench.cli.app import main
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.units import KNOT

SMOOTH = CalibrationOptions(model="smooth")


def inside(result, truth):
    curve = result.curve
    error = curve.correction - fixture.true_correction(curve.indicated_airspeed, truth)
    return np.abs(error) <= curve.two_sigma


@pytest.fixture(scope="module")
def calm():
    return fixture.fly(
        fixture.step_decrease(10), 10, 10, fixture.Air(gust=0.02, gps=0.02, pressure=2.0)
    )


def test_auto_is_the_smooth_curve_and_says_which_departures_the_log_supports(calm):
    smooth, auto = (calibrate(calm, CalibrationOptions(model=name)) for name in ("smooth", "auto"))
    assert auto.model == smooth.model == "smooth"
    np.testing.assert_array_equal(auto.curve.correction, smooth.curve.correction)
    assert sum(smooth.diagnostics.departures.values()) == pytest.approx(1.0, abs=1e-6)
    assert inside(smooth, fixture.TRUTH).all()


def test_a_drifting_wind_is_reported_by_its_mean():
    """As by a law: the level around which it would drift for ever is known ten times worse."""
    log = fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air(gust=0.15))
    named, smooth = (
        calibrate(log, CalibrationOptions(model=m, wind="drifting")) for m in ("inverse+", "smooth")
    )
    for axis in ("north", "east"):
        one, other = getattr(named.wind, axis), getattr(smooth.wind, axis)
        assert other.two_sigma < 2.0 * one.two_sigma
        assert abs(other.value - one.value) < one.two_sigma


def test_one_speed_has_an_answer():
    """A law of three terms has none: the slope is as unknown as its prior says."""
    speed, heading = fixture.step_decrease(10)
    log = fixture.fly(
        (np.full_like(speed, 120.0 * KNOT), heading), 10, 10, fixture.Air(pressure=1.0, gust=0.1)
    )
    result = calibrate(log, SMOOTH)
    assert inside(result, fixture.TRUTH).all()
    assert result.curve.two_sigma.max() < 2.0 * KNOT


def test_two_flights_share_one_curve_and_its_prior_counts_once():
    """Two equal halves of a flight know the curve about as well as the whole."""
    path = fixture.step_decrease(10)
    logs = [fixture.fly(path, 10, 10, fixture.Air(gust=0.1), seed) for seed in (7, 8)]
    alone = [calibrate(log, SMOOTH) for log in logs]
    joint = [each.calibration for each in calibrate_flights(logs, SMOOTH)]
    np.testing.assert_array_equal(joint[0].curve.correction, joint[1].curve.correction)
    assert inside(joint[0], fixture.TRUTH).mean() > 0.8
    one, both = alone[0].curve.two_sigma.mean(), joint[0].curve.two_sigma.mean()
    assert 0.5 * one < both < 0.9 * one


def test_auto_goes_with_no_other_method_and_is_offered_for_its_misspelling():
    for name in ("auto", "smooth"):
        with pytest.raises(BadInputError, match="'covering'"):
            CalibrationOptions(model=name, method="paper")
    with pytest.raises(UnknownNameError, match="Did you mean 'auto'"):
        CalibrationOptions(model="atuo")


def test_a_spline_is_the_smooth_curve():
    assert CalibrationOptions(model="spline").law == "smooth"


def test_command_line(calm, tmp_path, capsys):
    path = tmp_path / "log.parquet"
    write_log(calm, path)
    assert main(["calibrate", str(path), "--model", "auto", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["model"] == "smooth"
    assert len(found["parameters"]) == len(MODELS["smooth"].parameter_names)
    assert main(["calibrate", str(path), "--model", "smooth", "-v"]) == 0
    assert "departure of the curve from level, slope" in capsys.readouterr().out


STRUCTURE = Structure(PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE), (), drifting=False)


def log_prior_at(height_pressure):
    """The prior of a log at one static pressure."""
    log = fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air())
    log = replace(log, static_pressure=np.full(len(log), height_pressure))
    return log_prior_of(STRUCTURE, observe(log, CalibrationOptions()))


@pytest.mark.parametrize(
    ("height_pressure", "factor"), [(81200.0, 2.5), (69000.0, 4.0), (30000.0, 4.0)]
)
def test_a_length_one_factor_off_is_one_standard_deviation_off(height_pressure, factor):
    """2.5 low, 4 above 10,000 ft (69,682 Pa): gusts of 2,000 m are then nothing unusual."""
    log_prior = log_prior_at(height_pressure)
    usual = log_prior(np.log([0.5, PRIORS.gust_length_m, 0.05]))
    for length in (PRIORS.gust_length_m * factor, PRIORS.gust_length_m / factor):
        assert log_prior(np.log([0.5, length, 0.05])) - usual == pytest.approx(-0.5, abs=1e-9)


@pytest.mark.parametrize("level", [1e-4, 1e-2])
def test_of_small_gusts_every_size_is_as_likely_as_the_next(level):
    """Jeffreys' prior: ten times less is no less likely, so that calm air may be found calm."""
    log_prior = log_prior_at(81200.0)
    more, less = (
        log_prior(np.log([size, PRIORS.gust_length_m, 0.05])) for size in (level, 0.1 * level)
    )
    assert more == pytest.approx(less, abs=1e-4)


def test_the_noise_of_a_slow_receiver_is_no_slope_of_the_curve():
    """On legs in smooth air each airspeed is held to less than the noise of a fix. Read at the
    airspeed of the fixes, the curve swings by half a knot between them, more than its bound.
    """
    flight = fly(Case(maneuver="four_leg", turbulence="none", truth_seed=3, sensor_seed=3))
    curve = calibrate(sense(flight, "20/1"), SMOOTH).curve
    assert compare_curve(curve, flight.case.pressure_error).inside > 0.9
