"""Sensors that contradict their own integrals are found by that, before any force is judged."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.equations import noise_residuals
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.null_distribution import theoretical_distribution
from pitotbench.reconciliation.residuals import ATTITUDE_RATES
from pitotbench.reconciliation.verdict import judge
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import Verdict
from pitotbench.units import DEGREE

FEW = ("gyro_calibration", "accelerometer_calibration", "gps_latency", "updraft")
FEW_EFFECTS = Catalog("effect", {name: EFFECTS[name] for name in FEW})


def with_fault(log: FlightLog, channel: str, scale: float, zero: float) -> FlightLog:
    return replace(log, **{channel: (1.0 + scale) * np.asarray(getattr(log, channel)) + zero})


def sensors_of(log: FlightLog) -> Layout:
    return lay_out(log, None, AnalysisSetting(day_known=True), FEW_EFFECTS)


def told_by_sensors(log: FlightLog) -> Verdict:
    layout = sensors_of(log)
    return judge(["flight"], [layout], [theoretical_distribution(layout)]).verdict


@pytest.fixture(scope="module")
def log(sensed) -> FlightLog:
    return sensed(das="20/20")


@pytest.mark.parametrize(
    ("channel", "scale", "zero", "cause", "size", "true"),
    [
        ("yaw_rate", 0.12, 0.0, "gyro_calibration", "yaw_scale", 0.12),
        ("roll_rate", 0.0, -1.5 * DEGREE, "gyro_calibration", "roll_zero_degps", -1.5),
        ("specific_force_z", -0.08, 0.0, "accelerometer_calibration", "down_scale", -0.08),
        ("specific_force_x", 0.0, 0.6, "accelerometer_calibration", "forward_zero_g", 0.061),
    ],
)
def test_a_sensor_is_named_by_its_own_integral(log, channel, scale, zero, cause, size, true):
    verdict = told_by_sensors(with_fault(log, channel, scale, zero))
    assert [effect.name for effect in verdict.effects] == [cause]
    assert verdict.gaps[0].part == "attitude and inertial unit"
    (told,) = [each for each in verdict.effects[0].sizes if each.name == size]
    assert told.value == pytest.approx(true, rel=0.1)
    assert abs(told.value - true) < told.two_sigma


def test_sound_sensors_contradict_none_of_their_integrals(log):
    assert told_by_sensors(log).kind == "no_gap"
    layout = sensors_of(log)
    left = noise_residuals(layout)[:, [layout.residuals.places[n] for n in ATTITUDE_RATES]]
    assert np.abs(left.mean(axis=0)).max() < 0.02 * DEGREE
    assert left.std(axis=0).max() < 0.15 * DEGREE


def test_a_climb_is_what_the_altitude_gains(log):
    """The change of the altitude less the vertical speed: a speed that reads 1 m/s down shows whole."""
    layout = sensors_of(log)
    sinking = sensors_of(replace(log, velocity_down=log.velocity_down + 1.0))
    place = layout.residuals.places["climb_rate"]
    moved = (sinking.residuals.values - layout.residuals.values)[~layout.grid.first, place]
    np.testing.assert_allclose(moved, 1.0, atol=1e-9)
