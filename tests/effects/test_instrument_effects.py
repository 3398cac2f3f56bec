"""Compass, vanes, inertial unit, scales, pickups and humid air, each against a value worked out by hand."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.effects.sample_signals import applied, turning

from pitotbench import air
from pitotbench.effects.response import Signals
from pitotbench.units import DEGREE


def on_headings(*degrees: float) -> Signals:
    return Signals(np.arange(float(len(degrees))), {"heading": np.radians(degrees)})


def test_a_compass_errs_as_its_coefficients_say():
    """The coefficients by the rules of swinging a compass: B = (E − W)/2, C = (N − S)/2, D and E likewise."""
    before, after = applied("compass_deviation", on_headings(0, 90, 180, 270), sine_deg=2.0, cosine_deg=-1.0)
    north, east, south, west = (after["heading"] - before["heading"]) / DEGREE
    assert (east - west) / 2 == pytest.approx(2.0)
    assert (north - south) / 2 == pytest.approx(-1.0)
    before, after = applied("quadrantal_deviation", on_headings(0, 45, 90, 135), sine_deg=1.5, cosine_deg=0.5)
    north, northeast, east, southeast = (after["heading"] - before["heading"]) / DEGREE
    assert (northeast - southeast) / 2 == pytest.approx(1.5)
    assert (north - east) / 2 == pytest.approx(0.5)


@pytest.mark.parametrize(("name", "channel"), [("alpha", "angle_of_attack"), ("sideslip", "sideslip")])
def test_a_vane_has_a_scale_and_a_zero(name, channel):
    before, after = applied(f"{name}_vane_calibration", scale=0.25, offset_deg=2.0)
    line = np.polynomial.Polynomial.fit(before[channel], after[channel], 1).convert().coef
    np.testing.assert_allclose(line, [2.0 * DEGREE, 1.25], atol=1e-12)


def test_a_vane_that_sticks_rests_until_the_flow_has_turned_back_by_its_width():
    time = np.arange(0.0, 400.0, 0.1)
    alpha = 0.1 * np.sin(0.05 * time)
    signals = Signals(time, {"angle_of_attack": alpha, "sideslip": alpha})
    _, after = applied("vane_friction", signals, alpha_deg=1.0, sideslip_deg=0.0)
    error = (after["angle_of_attack"] - alpha) / DEGREE
    late, rising = time > 100.0, np.gradient(alpha) > 0.0
    inner = late & (np.abs(alpha) < 0.07)
    np.testing.assert_allclose(error[inner & rising], -0.5, atol=1e-9)
    np.testing.assert_allclose(error[inner & ~rising], 0.5, atol=1e-9)
    np.testing.assert_array_equal(after["sideslip"], alpha)


def test_a_misaligned_unit_reads_the_same_earth():
    """Against SciPy's rotations: the attitude of the unit is that of the airplane times the mount."""
    before, after = applied("inertial_unit_misalignment", roll_deg=2.0, pitch_deg=-3.0, yaw_deg=5.0)
    mount = Rotation.from_euler("ZYX", [5.0, -3.0, 2.0], degrees=True)

    def attitude(signals: Signals) -> Rotation:
        angles = np.stack([signals["heading"], signals["pitch"], signals["roll"]], axis=1)
        return Rotation.from_euler("ZYX", angles)

    def vectors(signals: Signals, *names: str) -> np.ndarray:
        return np.stack([signals[name] for name in names], axis=1)

    difference = (attitude(before) * mount).inv() * attitude(after)
    np.testing.assert_allclose(difference.magnitude(), 0.0, atol=1e-9)
    felt = ("specific_force_x", "specific_force_y", "specific_force_z")
    for names in (("roll_rate", "pitch_rate", "yaw_rate"), felt):
        np.testing.assert_allclose(vectors(after, *names), mount.inv().apply(vectors(before, *names)), atol=1e-12)
    # So gravity and all else that is felt has the same direction over the earth.
    np.testing.assert_allclose(
        attitude(after).apply(vectors(after, *felt)), attitude(before).apply(vectors(before, *felt)), atol=1e-9
    )
    assert np.abs(after["heading"] - before["heading"]).max() < 0.2  # no turn is lost at north


def test_a_nose_up_mount_reads_pitch_and_weight():
    level = dict.fromkeys(("roll", "pitch", "specific_force_x", "specific_force_y"), np.zeros(4))
    held = {"heading": np.full(4, 1.0), "specific_force_z": np.full(4, -9.8)}
    signals = Signals(np.arange(4.0), level | held)
    _, after = applied("inertial_unit_misalignment", signals, roll_deg=0.0, pitch_deg=1.5, yaw_deg=0.0)
    np.testing.assert_allclose(after["pitch"], 1.5 * DEGREE)
    np.testing.assert_allclose(after["specific_force_x"], 9.8 * np.sin(1.5 * DEGREE))
    np.testing.assert_allclose(after["specific_force_z"], -9.8 * np.cos(1.5 * DEGREE))


@pytest.mark.parametrize(
    ("name", "channel", "parameter"),
    [
        ("impact_pressure_scale", "impact_pressure", "scale"),
        ("static_pressure_scale", "static_pressure", "scale"),
        ("manifold_pressure_scale", "manifold_pressure_left", "left"),
        ("manifold_pressure_scale", "manifold_pressure_right", "right"),
        ("gps_velocity_scale", "velocity_north", "north"),
        ("gps_velocity_scale", "velocity_east", "east"),
    ],
)
def test_a_scale_is_a_factor_of_one_channel(name, channel, parameter):
    before, after = applied(name, **{parameter: 0.02})
    np.testing.assert_allclose(after[channel] / before[channel], 1.02)
    others = [other for other in before if other != channel]
    assert all(np.array_equal(after[other], before[other]) for other in others)


def test_a_scale_of_the_impact_pressure_is_a_loss_of_total_pressure():
    signals = turning()
    _, scaled = applied("impact_pressure_scale", signals, scale=-0.03)
    _, lost = applied("total_pressure_loss", signals, fraction=0.03)
    np.testing.assert_allclose(scaled["impact_pressure"], lost["impact_pressure"])


def test_a_static_transducer_with_hysteresis_reads_higher_in_a_climb():
    time = np.arange(0.0, 200.0, 0.1)
    static = 80000.0 + 3000.0 * np.sin(0.05 * time)
    _, after = applied("static_hysteresis", Signals(time, {"static_pressure": static}), width_pa=120.0)
    error, climbing = after["static_pressure"] - static, np.gradient(static) < 0.0
    inner = (time > 60.0) & (np.abs(static - 80000.0) < 2000.0)
    np.testing.assert_allclose(error[inner & climbing], 60.0, atol=1e-8)
    np.testing.assert_allclose(error[inner & ~climbing], -60.0, atol=1e-8)


def test_a_bent_pickup_is_right_at_both_ends_and_off_by_its_bend_between_them():
    n = 3
    plates = {"throttle_left": np.array([0.0, 0.5, 1.0]), "throttle_right": np.full(n, 0.5)}
    _, after = applied("throttle_pickup", Signals(np.arange(float(n)), plates), left=0.04, right=-0.1)
    np.testing.assert_allclose(after["throttle_left"], [0.0, 0.54, 1.0])
    np.testing.assert_allclose(after["throttle_right"], 0.4)


def test_humid_air_has_its_density_and_reads_colder():
    """By the gas law of each gas alone: the moist air that the probe measures is as dense as the case's dry air."""
    pressure, case_temperature = 90000.0, 300.0
    at_rest = {"impact_pressure": 0.0, "static_pressure": pressure, "total_temperature": case_temperature}
    signals = Signals(np.arange(2.0), {name: np.full(2, value) for name, value in at_rest.items()})
    _, after = applied("humid_air", signals, relative_humidity=0.8)
    temperature = float(after["total_temperature"][0])
    # Saturation by the table of the World Meteorological Organization: 31.67 hPa at 25 °C, 33.61 hPa at 26 °C
    saturation = np.interp(temperature, [297.15, 298.15, 299.15], [2983.0, 3167.0, 3361.0])
    vapor = 0.8 * saturation
    density = (pressure - vapor) / (287.05 * temperature) + vapor / (461.5 * temperature)
    assert density == pytest.approx(pressure / (air.GAS_CONSTANT * case_temperature), rel=1e-4)
    # By hand, with 29.83 hPa at 24 °C: 300 K · 0.378 · 0.8 · 2983 / 90000
    assert case_temperature - temperature == pytest.approx(3.0, abs=0.05)


def test_the_antenna_has_a_height_of_its_own():
    """Against the geometry: an antenna ahead and above rises with pitch; to the right, it sinks with bank."""
    still = ("heading", "roll_rate", "pitch_rate", "yaw_rate", "velocity_north", "velocity_east")
    moved = {"roll": np.array([0.0, 0.0, 0.5]), "pitch": np.array([0.0, 0.2, 0.0]), "altitude": np.full(3, 1000.0)}
    signals = Signals(np.arange(3.0), dict.fromkeys(still, np.zeros(3)) | moved)
    _, after = applied("antenna_lever_arm", signals, forward_m=3.0, right_m=2.0, down_m=-1.5)
    expected = [1.5, 3.0 * np.sin(0.2) + 1.5 * np.cos(0.2), 1.5 * np.cos(0.5) - 2.0 * np.sin(0.5)]
    np.testing.assert_allclose(after["altitude"] - 1000.0, expected)
