"""Sensor effects, each against a value worked out by hand."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.effects.sample_signals import applied, turning

from pitotbench import air
from pitotbench.effects import EFFECTS
from pitotbench.effects.response import Signals
from pitotbench.units import DEGREE, KNOT


def total(signals: Signals) -> np.ndarray:
    return signals["impact_pressure"] + signals["static_pressure"]


def lateness(before: np.ndarray, after: np.ndarray, interval: float) -> float:
    """The shift [s] that fits best, by least squares on the slope."""
    slope = np.gradient(before, interval)
    return float(-(slope @ (after - before)) / (slope @ slope))


@pytest.mark.parametrize("name", ["pitot_lag", "second_order_line"])
def test_a_pitot_line_delays_total_pressure_by_its_lag(name):
    before, after = applied(name, turning(600.0), lag_s=0.3)
    assert lateness(total(before), total(after), before.interval) == pytest.approx(0.3, rel=0.01)


def test_a_static_line_delays_static_and_leaves_total():
    before, after = applied("static_lag", turning(600.0), lag_s=0.5)
    assert lateness(
        before["static_pressure"], after["static_pressure"], before.interval
    ) == pytest.approx(0.5, rel=0.01)
    np.testing.assert_allclose(total(after), total(before), atol=1e-9)


def test_a_line_is_slower_in_thin_air():
    before, after = applied("height_dependent_lag", turning(600.0), sea_level_lag_s=0.3)
    cold = (276.5 / 288.15) ** 0.75
    expected = 0.3 * cold * air.SEA_LEVEL_PRESSURE / 81000.0
    assert lateness(total(before), total(after), before.interval) == pytest.approx(
        expected, rel=0.02
    )


@pytest.mark.parametrize(
    "name",
    [
        "static_source_change",
        "local_static_bump",
        "alpha_static_error",
        "sideslip_static_error",
        "propwash_error",
        "static_lag",
    ],
)
def test_an_error_of_the_static_source_leaves_the_total_pressure(name):
    before, after = applied(name, **EFFECTS[name].typical())
    np.testing.assert_allclose(total(after), total(before), atol=1e-9)


def test_the_changed_curve_has_its_values_at_its_speeds():
    time = np.arange(4.0)
    impact = np.asarray(air.impact_pressure(np.array([100.0, 130.0, 160.0, 160.0]) * KNOT))
    signals = Signals(time, {"impact_pressure": impact, "static_pressure": np.full(4, 8e4)})
    _, after = applied(
        "static_source_change", signals, coefficient_at_100kt=0.02, coefficient_at_160kt=-0.01
    )
    share = (after["static_pressure"] - 8e4) / impact
    np.testing.assert_allclose(share, [0.02, 0.005, -0.01, -0.01], atol=1e-9)


def test_flow_angles_and_power_scale_the_error():
    signals = turning()
    q, alpha, beta = signals["impact_pressure"], signals["angle_of_attack"], signals["sideslip"]
    for name, sizes, expected in (
        ("alpha_static_error", {"slope_per_rad": 0.2}, 0.2 * alpha * q),
        (
            "sideslip_static_error",
            {"slope_per_rad": 0.1, "curvature_per_rad2": -1.0},
            (0.1 * beta - beta**2) * q,
        ),
    ):
        _, after = applied(name, signals, **sizes)
        np.testing.assert_allclose(
            after["static_pressure"] - signals["static_pressure"], expected, atol=1e-8
        )
    stopped = signals.with_channels(
        manifold_pressure_left=0.0 * q,
        manifold_pressure_right=0.0 * q,
        impact_pressure=np.full_like(q, 2000.0),
    )
    _, after = applied("propwash_error", stopped, pressure_pa=50.0)
    np.testing.assert_array_equal(after["static_pressure"], stopped["static_pressure"])


def test_losses_and_leaks_take_their_share():
    before, after = applied("total_pressure_loss", fraction=0.02)
    np.testing.assert_allclose(after["impact_pressure"], 0.98 * before["impact_pressure"])
    _, scaled = applied(
        "impact_pressure_scale", scale=-0.02
    )  # a scale of the impact pressure is such a loss
    np.testing.assert_allclose(scaled["impact_pressure"], after["impact_pressure"])
    before, after = applied("line_leak", fraction=0.04)
    np.testing.assert_allclose(after["impact_pressure"], 0.96 * before["impact_pressure"])
    np.testing.assert_allclose(
        total(after) - total(before), -0.02 * before["impact_pressure"], atol=1e-8
    )
    before, after = applied("inclined_pitot_loss", loss_per_rad2=2.0)
    lost = 1.0 - after["impact_pressure"] / before["impact_pressure"]
    np.testing.assert_allclose(lost, 2.0 * before["angle_of_attack"] ** 2, atol=1e-12)


def test_drifts_grow_with_time_and_temperature():
    before, after = applied("time_drift", turning(pause=60.0), rate_pa_per_min=3.0)
    assert (after["impact_pressure"] - before["impact_pressure"])[-1] == pytest.approx(
        9.0, rel=1e-3
    )
    before, after = applied("temperature_drift", shift_pa_per_k=5.0)
    warmer = before["total_temperature"] - before["total_temperature"][0]
    np.testing.assert_allclose(
        after["impact_pressure"] - before["impact_pressure"], 5.0 * warmer, atol=1e-9
    )


@pytest.mark.parametrize(
    ("name", "channel", "sizes", "mean", "swing", "width", "within"),
    [
        ("hysteresis", "impact_pressure", {"width_pa": 40.0}, 2000.0, 1000.0, 40.0, 1e-9),
        ("static_hysteresis", "static_pressure", {"width_pa": 120.0}, 80000.0, 3000.0, 120.0, 1e-8),
        # A vane that sticks rests until the flow has turned back by its width.
        (
            "vane_friction",
            "angle_of_attack",
            {"alpha_deg": 1.0, "sideslip_deg": 0.0},
            0.0,
            0.1,
            DEGREE,
            1e-11,
        ),
    ],
)
def test_hysteresis_reads_a_width_apart_up_and_down(
    name, channel, sizes, mean, swing, width, within
):
    time = np.arange(0.0, 400.0, 0.1)
    values = mean + swing * np.sin(0.05 * time)
    _, after = applied(name, Signals(time, {channel: values, "sideslip": values}), **sizes)
    error, rising = after[channel] - values, np.gradient(values) > 0.0
    middle = (np.abs(values - mean) < 0.5 * swing) & (time > 100.0)
    np.testing.assert_allclose(error[middle & rising], -0.5 * width, rtol=0.0, atol=within)
    np.testing.assert_allclose(error[middle & ~rising], 0.5 * width, rtol=0.0, atol=within)
    np.testing.assert_array_equal(after["sideslip"], values)


def test_water_weighs_by_specific_force():
    before, after = applied("water_in_line", column_m=0.05, lag_s=0.0)
    head = before["impact_pressure"] - after["impact_pressure"]
    np.testing.assert_allclose(head, 1000.0 * 0.05 * before["specific_force_x"], atol=1e-8)


def test_gps_is_late_by_the_latency_and_the_clocks_run_apart():
    before, after = applied("gps_latency", turning(600.0), latency_s=0.4)
    north = (before["velocity_north"], after["velocity_north"])
    assert lateness(*north, before.interval) == pytest.approx(0.4, rel=0.01)
    before, after = applied("clock_drift", turning(600.0), drift_ppm=1000.0)
    end = slice(-2000, None)
    late = lateness(before["velocity_north"][end], after["velocity_north"][end], before.interval)
    assert late == pytest.approx(0.58, rel=0.01)


def test_held_values_repeat_for_their_period_and_begin_anew_after_a_pause():
    before, after = applied("sample_and_hold", turning(40.0, pause=3.33), period_s=0.5)
    for part in before.stretches():
        runs = np.flatnonzero(np.diff(after["impact_pressure"][part])) + 1
        assert set(np.diff(runs)) == {25}
        np.testing.assert_array_equal(
            after["impact_pressure"][part][runs], before["impact_pressure"][part][runs]
        )


def test_lost_samples_repeat_the_last_good_one():
    before, after = applied("dropped_samples", turning(400.0), fraction=0.05, seed=3.0)
    repeated = np.concatenate([[False], np.diff(after["impact_pressure"]) == 0.0])
    assert np.mean(repeated) == pytest.approx(0.05, rel=0.15)
    np.testing.assert_array_equal(
        after["impact_pressure"][~repeated], before["impact_pressure"][~repeated]
    )
    _, again = applied("dropped_samples", before, fraction=0.05, seed=3.0)
    np.testing.assert_array_equal(again["impact_pressure"], after["impact_pressure"])


def test_words_and_ceilings():
    _, after = applied("quantization", step_pa=25.0)
    for name in ("impact_pressure", "static_pressure"):
        np.testing.assert_allclose(after[name] % 25.0, 0.0)
    before, after = applied("saturation", ceiling_pa=3000.0)
    np.testing.assert_array_equal(
        after["impact_pressure"], np.minimum(before["impact_pressure"], 3000.0)
    )


def test_the_antennas_velocity_is_the_rate_of_its_place_and_its_height_its_own():
    """Against numerical differentiation of an attitude that moves in all three angles."""
    time = np.arange(0.0, 20.0, 0.001)
    roll, pitch, heading = (
        0.4 * np.sin(time),
        0.2 * np.cos(0.7 * time),
        1.0 + 0.3 * np.sin(0.5 * time),
    )
    dr, dp, dh = (np.gradient(angle, time) for angle in (roll, pitch, heading))
    rates = {
        "roll_rate": dr - dh * np.sin(pitch),
        "pitch_rate": dp * np.cos(roll) + dh * np.cos(pitch) * np.sin(roll),
        "yaw_rate": dh * np.cos(pitch) * np.cos(roll) - dp * np.sin(roll),
    }
    still = ("velocity_north", "velocity_east", "velocity_down", "altitude")
    attitude = {"roll": roll, "pitch": pitch, "heading": heading}
    signals = Signals(time, {**attitude, **rates, **dict.fromkeys(still, np.zeros_like(time))})
    _, after = applied("antenna_lever_arm", signals, forward_m=2.0, right_m=-1.5, down_m=0.7)
    place = Rotation.from_euler("ZYX", np.stack([heading, pitch, roll], axis=1)).apply(
        [2.0, -1.5, 0.7]
    )
    for axis, along in zip(("north", "east", "down"), place.T, strict=True):
        np.testing.assert_allclose(
            after[f"velocity_{axis}"][5:-5], np.gradient(along, time)[5:-5], atol=1e-5
        )
    np.testing.assert_allclose(after["altitude"], -place[:, 2], atol=1e-12)


def test_the_probe_recovers_less_or_reads_warm():
    before, after = applied("recovery_deficit", deficit=0.25)
    mach = air.mach_from_impact_pressure(before["impact_pressure"], before["static_pressure"])
    cold = air.air_temperature(before["total_temperature"], mach)
    ram = before["total_temperature"] - cold
    np.testing.assert_allclose(
        before["total_temperature"] - after["total_temperature"], 0.25 * ram, atol=1e-9
    )
    before, after = applied("temperature_bias", bias_k=2.5)
    np.testing.assert_allclose(
        after["total_temperature"] - before["total_temperature"], 2.5, atol=1e-9
    )


def test_effects_combine_in_any_order_where_they_share_no_channel():
    signals = turning()
    late, warm = EFFECTS["gps_latency"], EFFECTS["temperature_bias"]
    one = warm.apply(late.apply(signals, late.typical()), warm.typical())
    other = late.apply(warm.apply(signals, warm.typical()), late.typical())
    assert all(np.array_equal(one[name], other[name]) for name in one)


def test_nothing_is_held_across_a_pause():
    """The recorder begins anew after a pause: what it repeats is never from before."""
    signals = turning(40.0, pause=100.0)
    later = signals.time > 100.0
    marked = signals.with_channels(static_pressure=np.where(later, 7e4, 8e4))
    held = [("sample_and_hold", {"period_s": 3.0})]
    held += [
        ("dropped_samples", {"fraction": 0.5, "burst_rows": 30.0, "seed": float(seed)})
        for seed in range(5)
    ]
    for name, sizes in held:
        _, after = applied(name, marked, **sizes)
        np.testing.assert_array_equal(after["static_pressure"], marked["static_pressure"])


def on_headings(*degrees: float) -> Signals:
    return Signals(np.arange(float(len(degrees))), {"heading": np.radians(degrees)})


def test_a_compass_errs_as_its_coefficients_say():
    """The coefficients by the rules of swinging a compass: B = (E − W)/2, C = (N − S)/2, D and E
    likewise.
    """
    before, after = applied(
        "compass_deviation", on_headings(0, 90, 180, 270), sine_deg=2.0, cosine_deg=-1.0
    )
    north, east, south, west = (after["heading"] - before["heading"]) / DEGREE
    assert (east - west) / 2 == pytest.approx(2.0)
    assert (north - south) / 2 == pytest.approx(-1.0)
    before, after = applied(
        "quadrantal_deviation", on_headings(0, 45, 90, 135), sine_deg=1.5, cosine_deg=0.5
    )
    north, northeast, east, southeast = (after["heading"] - before["heading"]) / DEGREE
    assert (northeast - southeast) / 2 == pytest.approx(1.5)
    assert (north - east) / 2 == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("name", "channel"), [("alpha", "angle_of_attack"), ("sideslip", "sideslip")]
)
def test_a_vane_has_a_scale_and_a_zero(name, channel):
    before, after = applied(f"{name}_vane_calibration", scale=0.25, offset_deg=2.0)
    line = np.polynomial.Polynomial.fit(before[channel], after[channel], 1).convert().coef
    np.testing.assert_allclose(line, [2.0 * DEGREE, 1.25], atol=1e-12)


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
        np.testing.assert_allclose(
            vectors(after, *names), mount.inv().apply(vectors(before, *names)), atol=1e-12
        )
    # So gravity and all else that is felt has the same direction over the earth.
    np.testing.assert_allclose(
        attitude(after).apply(vectors(after, *felt)),
        attitude(before).apply(vectors(before, *felt)),
        atol=1e-9,
    )
    assert np.abs(after["heading"] - before["heading"]).max() < 0.2  # no turn is lost at north


@pytest.mark.parametrize(
    ("name", "channel", "parameter"),
    [
        ("impact_pressure_scale", "impact_pressure", "scale"),
        ("static_pressure_scale", "static_pressure", "scale"),
        ("manifold_pressure_scale", "manifold_pressure_left", "left"),
        ("manifold_pressure_scale", "manifold_pressure_right", "right"),
        ("gps_velocity_scale", "velocity_north", "north"),
        ("gps_velocity_scale", "velocity_east", "east"),
        ("gyro_calibration", "pitch_rate", "pitch_scale"),
        ("accelerometer_calibration", "specific_force_y", "right_scale"),
    ],
)
def test_a_scale_is_a_factor_of_one_channel(name, channel, parameter):
    before, after = applied(name, **{parameter: 0.02})
    np.testing.assert_allclose(after[channel] / before[channel], 1.02)
    others = [other for other in before if other != channel]
    assert all(np.array_equal(after[other], before[other]) for other in others)


@pytest.mark.parametrize(
    ("name", "channel", "parameter", "unit"),
    [
        ("gyro_calibration", "yaw_rate", "yaw_zero_degps", DEGREE),
        ("accelerometer_calibration", "specific_force_z", "down_zero_g", 9.80665),
    ],
)
def test_a_zero_adds_to_one_sensor_of_the_inertial_unit(name, channel, parameter, unit):
    before, after = applied(name, **{parameter: 0.5})
    np.testing.assert_allclose(after[channel] - before[channel], 0.5 * unit)
    assert all(np.array_equal(after[o], before[o]) for o in before if o != channel)


def test_a_bent_pickup_is_right_at_both_ends_and_off_by_its_bend_between_them():
    n = 3
    plates = {"throttle_left": np.array([0.0, 0.5, 1.0]), "throttle_right": np.full(n, 0.5)}
    _, after = applied(
        "throttle_pickup", Signals(np.arange(float(n)), plates), left=0.04, right=-0.1
    )
    np.testing.assert_allclose(after["throttle_left"], [0.0, 0.54, 1.0])
    np.testing.assert_allclose(after["throttle_right"], 0.4)


def test_humid_air_has_its_density_and_reads_colder():
    """By the gas law of each gas alone: the moist air that the probe measures is as dense as the
    case's dry air.
    """
    pressure, case_temperature = 90000.0, 300.0
    at_rest = {
        "impact_pressure": 0.0,
        "static_pressure": pressure,
        "total_temperature": case_temperature,
    }
    signals = Signals(np.arange(2.0), {name: np.full(2, value) for name, value in at_rest.items()})
    _, after = applied("humid_air", signals, relative_humidity=0.8)
    temperature = float(after["total_temperature"][0])
    # Saturation by the table of the World Meteorological Organization: 31.67 hPa at 25 °C, 33.61
    # hPa at 26 °C
    saturation = np.interp(temperature, [297.15, 298.15, 299.15], [2983.0, 3167.0, 3361.0])
    vapor = 0.8 * saturation
    density = (pressure - vapor) / (287.05 * temperature) + vapor / (461.5 * temperature)
    assert density == pytest.approx(pressure / (air.GAS_CONSTANT * case_temperature), rel=1e-4)
    # By hand, with 29.83 hPa at 24 °C: 300 K · 0.378 · 0.8 · 2983 / 90000
    assert case_temperature - temperature == pytest.approx(3.0, abs=0.05)
