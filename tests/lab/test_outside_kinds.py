"""The kinds and sets of flights beyond the judge's cells: truth and display by formulas written
here once more.
"""

import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from pitotbench.logbook.reading import read_log
from pitotlab.outside import kinds
from pitotlab.outside import physics as physics
from pitotlab.outside.generator import generate
from pitotlab.outside.kinds import FAULTS, KINDS, OTHERS
from pitotlab.outside.motion import NOISE, RATE
from pitotlab.outside.moving_air import BASE
from pitotlab.outside.physics import FOOT, KNOT
from pitotlab.outside.written import truth_of, write_set

SEED = 4
ALL = KINDS | OTHERS
RAW = {name: replace(cell, shown=(), log_rate=RATE, trim=0.0) for name, cell in ALL.items()}


@pytest.fixture(scope="module")
def raw():
    """A flight of each kind with all its rows, as the sensors give them."""
    return {name: generate(cell, "rapid_decel", SEED) for name, cell in RAW.items()}


def _airspeed(impact):
    """Calibrated airspeed [kt] by the plain formula of Rayleigh and Saint-Venant."""
    sound = np.sqrt(1.4 * 287.053 * 288.15)
    return sound * np.sqrt(5.0 * ((impact / 101325.0 + 1.0) ** (2.0 / 7.0) - 1.0)) / KNOT


@pytest.fixture(scope="module")
def faults():
    """A flight of each fault, with the rows and the display of its recorder."""
    return {
        name: generate(replace(cell, log_rate=RATE), cell.maneuvers[-1], SEED)
        for name, cell in FAULTS.items()
    }


def test_the_vertical_velocity_the_height_and_the_pressure_fit_one_another(raw, faults):
    """The height is the integral of the velocity, and the pressure that of the weight of the air
    along the path, less what the wind needs.
    """
    for name, flight in (raw | faults).items():
        state, sky = flight.state, flight.sky
        climbed = -_integral(state.ground_velocity[:, 2])
        np.testing.assert_allclose(state.height, state.height[0] + climbed, atol=0.1, err_msg=name)
        toward_north, toward_east = sky.gradient()
        density = state.pressure / (287.053 * state.temperature)
        slope = 9.80665 * density * state.ground_velocity[:, 2]
        slope += state.ground_velocity[:, :2] @ [toward_north, toward_east]
        np.testing.assert_allclose(
            state.pressure, state.pressure[0] + _integral(slope), atol=1.5, err_msg=name
        )


def test_the_receiver_reports_a_height_that_its_vertical_velocity_explains(raw, faults):
    """To within its slow error of 2 m; the display of a barometric height is not a receiver's."""
    for name, flight in (raw | faults).items():
        columns = flight.columns
        down = np.interp(flight.state.time, columns["time_s"], columns["velocity_down_mps"])
        height = np.interp(flight.state.time, columns["time_s"], columns["altitude_m"])
        apart = height + _integral(down)
        assert np.std(apart) < 3.5, name


def _integral(rate):
    """Of a rate a row, from the first row, by the trapezoidal rule."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]))]) / RATE


def _shares(flight):
    """Errors of the static and of the total source as the log shows them, in shares of q_c."""
    state, columns = flight.state, flight.columns
    static = columns["static_pressure_pa"] - state.pressure
    total = static + columns["impact_pressure_pa"] - state.impact
    return static / state.impact, total / state.impact


def _in_level(flight):
    """The place of each row in the curve: q_ci in level flight at its true impact pressure [Pa]."""
    shown = np.linspace(500.0, 8000.0, 4001)
    return np.interp(flight.state.impact, shown / (1.0 - flight.error.share(shown)), shown)


def _means_of(values, rows=200):
    return values[: len(values) // rows * rows].reshape(-1, rows).mean(axis=1)


LOWEST = 101325.0 * ((1.0 + 0.2 * (100.0 * KNOT / 340.294) ** 2) ** 3.5 - 1.0)  # Pa, at 100 kt


def test_a_lift_part_grows_with_the_load_over_the_impact_pressure(faults):
    flight = faults["lift"]
    load = 1.0 / np.cos(flight.columns["roll_rad"])
    assert np.quantile(load, 0.9) == pytest.approx(np.sqrt(2.0), abs=0.15)
    level = flight.error.k[0]
    expected = level + 0.06 * load * LOWEST / _in_level(flight)
    static, total = _shares(flight)
    np.testing.assert_allclose(_means_of(static), _means_of(expected), atol=0.002)
    np.testing.assert_allclose(_means_of(total), 0.0, atol=0.003)


def test_a_tube_loses_with_the_square_of_the_load_over_the_impact_pressure(faults):
    flight = faults["loss"]
    load = 1.0 / np.cos(flight.columns["roll_rad"])
    static, total = _shares(flight)
    lost = 0.04 * (load * LOWEST / _in_level(flight)) ** 2
    np.testing.assert_allclose(_means_of(total), -_means_of(lost), atol=0.003)
    known = flight.error.static.share(_in_level(flight))
    np.testing.assert_allclose(_means_of(static), _means_of(known), atol=0.002)


def test_sideslip_raises_the_static_pressure_in_turns_to_one_side_and_lowers_it_in_the_other():
    for seed in range(4):
        flight = generate(replace(FAULTS["sideslip"], log_rate=RATE), "circle", seed)
        level = flight.error.share(_in_level(flight))
        static, _ = _shares(flight)
        bank = flight.columns["roll_rad"]
        expected = 0.015 * np.tan(bank) / np.tan(np.radians(30.0))
        np.testing.assert_allclose(_means_of(static - level), _means_of(expected), atol=0.002)
        assert abs(np.median(expected)) == pytest.approx(0.015, abs=0.003)


def test_the_level_curve_of_a_fault_is_its_truth():
    """What only turns show is in no entry of the truth: its curve is that of straight flight."""
    for name in ("lift", "loss", "sideslip"):
        flight = generate(replace(FAULTS[name], log_rate=RATE), "step_decrease", SEED)
        truth, state = truth_of(flight), flight.state
        shown, at = _airspeed(state.indicated_impact), truth["indicated_airspeed_kt"]
        flown, rate = (shown > at[0]) & (shown < at[-1]), np.abs(state.turn_rate)
        straight, turning = flown & (rate < 1e-6), flown & (rate > 0.04)
        off = shown + np.interp(shown, at, truth["correction_kt"]) - _airspeed(state.impact)
        assert np.mean(straight) > 0.3
        assert np.max(np.abs(off[straight])) < 0.01
        assert np.max(np.abs(off[turning])) > 0.1


def test_a_receiver_that_smooths_trails_in_its_velocity_and_where_it_says_so_in_its_height(faults):
    """A lag of the first order trails a slow change by its time."""
    for name, of_height in (("smoothed", 2.0), ("smoothed_velocity", 0.0)):
        state, columns = faults[name].state, faults[name].columns
        twin = replace(FAULTS[name], log_rate=RATE, gps_filter=0.0, height_late=0.0)
        exact = generate(twin, "circle", SEED).columns  # with the same noise
        for channel, true, trails in (
            ("velocity_north_mps", state.ground_velocity[:, 0], 2.0),
            ("altitude_m", state.height, of_height),
        ):
            shown = columns[channel] - exact[channel] + true
            shifts = [np.interp(state.time - late, state.time, true) for late in (0.0, 1.0, 2.0)]
            apart = [np.std((shown - each)[100:-100]) for each in shifts]
            assert np.argmin(apart) == trails, (name, channel)


def test_a_probe_that_is_warm_when_slow_is_right_when_fast(faults):
    flight, twin = faults["warm_slow"], replace(FAULTS["warm_slow"], log_rate=RATE, probe_warm=0.0)
    right = generate(twin, flight.maneuver, SEED).columns
    channel = next(name for name in right if name.endswith("temperature_k"))
    off = flight.columns[channel] - right[channel]
    airspeed = _airspeed(flight.state.impact)
    slow, fast = np.abs(airspeed - 100.0) < 0.5, np.abs(airspeed - 160.0) < 0.5
    assert np.mean(off[slow]) == pytest.approx(6.0, abs=0.1)
    assert np.mean(off[fast]) == pytest.approx(0.0, abs=0.1)
    assert np.corrcoef(off, 1.0 / flight.state.impact)[0, 1] > 1.0 - 1e-9


def test_a_leak_and_a_scale_change_the_impact_pressure_by_what_they_say(faults):
    _, total = _shares(faults["leak"])
    np.testing.assert_allclose(_means_of(total), -0.06, atol=0.003)
    for name, scale in (("scale_+4", 1.04), ("scale_-4", 0.96)):
        flight = faults[name]
        read = flight.columns["impact_pressure_pa"] / flight.state.indicated_impact
        assert np.mean(read) == pytest.approx(scale, abs=1e-4)


def test_a_recorder_of_means_stores_the_mean_of_each_span(faults):
    columns = faults["means"].columns
    plain = generate(replace(FAULTS["means"], shown=()), "circle", SEED).columns
    assert np.diff(columns["time_s"]) == pytest.approx(5.0)
    for name in ("velocity_north_mps", "impact_pressure_pa", "altitude_m"):
        np.testing.assert_allclose(columns[name], _means_of(plain[name], 100))
    turned = np.diff(np.unwrap(columns["heading_rad"]))
    assert np.max(np.abs(turned)) < np.radians(60.0)  # 5 s at 30° of bank


def test_an_altitude_that_a_computer_corrects_is_off_by_5_percent_of_the_impact_pressure(faults):
    signs = set()
    for seed in range(4):
        columns = generate(FAULTS["height_off"], "rapid_decel", seed).columns
        plain = generate(replace(FAULTS["height_off"], drawn=None), "rapid_decel", seed).columns
        lightness = 1.0 - 0.0065 / 288.15 * columns["pressure_altitude_ft"] * FOOT
        shown = 101325.0 * lightness ** (9.80665 / 287.053 / 0.0065)
        share = (shown - plain["static_pressure_pa"]) / plain["impact_pressure_pa"]
        assert np.abs(share) == pytest.approx(0.05, abs=1e-6)
        signs.add(np.sign(share[0]))
        shown = _airspeed(plain["impact_pressure_pa"])
        np.testing.assert_allclose(columns["indicated_airspeed_kt"], shown)
    assert signs == {-1.0, 1.0}


def test_a_log_of_climbs_goes_up_and_down_by_more_than_a_thousand_feet():
    for maneuver in FAULTS["climbs_20k"].maneuvers:
        for seed in range(8):
            height = generate(FAULTS["climbs_20k"], maneuver, seed).state.height
            assert np.ptp(height) > 1000.0 * FOOT


def test_good_flights_have_banks_and_gusts_of_many_sizes():
    dice = np.random.default_rng(1)
    drawn = [kinds.draw_good(FAULTS["good"], dice) for _ in range(2000)]
    banks = np.degrees([cell.bank for cell in drawn])
    assert np.quantile(banks, [0.0, 0.5, 1.0]) == pytest.approx([15.0, 30.0, 45.0], abs=1.0)
    for name, median in (("gust_sigma", 0.5), ("gust_length", 300.0)):
        logs = np.log([getattr(cell, name) for cell in drawn])
        assert np.exp(np.mean(logs)) == pytest.approx(median, rel=0.06)
        assert np.std(logs) == pytest.approx(np.log(1.8), rel=0.06)


def test_there_are_27_kinds():
    assert len(KINDS) == 27
    for named in (KINDS, FAULTS, OTHERS):
        assert [cell.name for cell in named.values()] == list(named)


@pytest.mark.parametrize("name", ALL)
def test_the_written_truth_joins_what_the_log_shows_with_the_true_airspeed(raw, name):
    flight = raw[name]
    state, cell, truth = flight.state, flight.cell, truth_of(flight)
    shown = _airspeed(cell.impact_scale * state.indicated_impact + cell.impact_zero)
    at = truth["indicated_airspeed_kt"]
    flown = (shown > at[0]) & (shown < at[-1])
    assert np.mean(flown) > 0.3
    found = np.interp(shown, at, truth["correction_kt"])
    np.testing.assert_allclose((found + shown - _airspeed(state.impact))[flown], 0.0, atol=0.01)
    wind = flight.sky.wind[:2] + np.mean(state.slow_wind[:, :2], axis=0)
    np.testing.assert_allclose(truth["mean_wind_kt"], wind / KNOT)


@pytest.mark.parametrize("name", ALL)
def test_the_columns_are_the_pressures_of_the_two_sources_and_the_errors_of_the_sensors(raw, name):
    flight = raw[name]
    state, cell, columns = flight.state, flight.cell, flight.columns
    both = flight.error.share(state.indicated_impact)
    of_total = (
        flight.error.total.share(state.indicated_impact)
        if isinstance(flight.error, physics.TwoSources)
        else 0.0
    )
    static = state.pressure + (both - of_total) * state.impact + cell.static_bias
    impact = cell.impact_scale * (1.0 - both) * state.impact + cell.impact_zero
    for channel, true, noise in (
        ("static_pressure_pa", static, NOISE.static),
        ("impact_pressure_pa", impact, NOISE.impact),
    ):
        if channel == "impact_pressure_pa" and cell.airspeed_step:
            continue
        error = columns[channel] - true
        assert abs(np.mean(error)) < 4.0 * noise / np.sqrt(len(error))
        assert np.std(error) == pytest.approx(noise, rel=0.05)


@pytest.mark.parametrize("name", ["priors", "scale", "c172s"])
def test_the_position_error_is_that_of_the_static_source_alone(raw, name):
    flight, truth = raw[name], truth_of(raw[name])
    add = np.array(truth["correction_kt"]) + truth["indicated_airspeed_kt"]
    impact = physics.impact_pressure(add * KNOT)
    error = flight.error
    static = error.static if isinstance(error, physics.TwoSources) else error
    shown = physics.impact_pressure(np.array(truth["indicated_airspeed_kt"]) * KNOT)
    sources = (shown - flight.cell.impact_zero) / flight.cell.impact_scale
    pressure = float(flight.sky.day.pressure(np.array(flight.cell.height)))
    standard = 288.15 * (pressure / 101325.0) ** 0.190263  # K
    feet = static.share(sources) * impact * 287.053 * standard / (pressure * 9.80665) / FOOT
    np.testing.assert_allclose(truth["position_error_ft"], feet, rtol=0.01, atol=0.05)


def test_the_handbook_and_the_light_airplane_are_what_they_say():
    book = truth_of(generate(OTHERS["c172s"], "rapid_decel", SEED))
    at = book["indicated_airspeed_kt"]
    assert at[0] == pytest.approx(55.0)
    assert at[-1] == pytest.approx(115.0)
    found = np.interp([60.0, 70.0, 80.0, 90.0, 100.0, 110.0], at, book["correction_kt"])
    assert found == pytest.approx([2.0, 0.0, -2.0, -3.0, -3.0, -3.0], abs=0.02)
    error = generate(OTHERS["light"], "rapid_decel", SEED).error
    ends = physics.impact_pressure(np.array([55.0, 115.0]) * KNOT)
    middle = np.sqrt(ends[0] * ends[1])
    assert error.share(np.array([ends[0], middle, ends[1]])) == pytest.approx([0.1, 0.025, -0.05])


def test_heights_go_from_level_to_level_at_500_feet_a_minute(raw):
    for name, step in (("shear", 150.0 * FOOT), ("probe_lag_climbs", 500.0 * FOOT)):
        flown = raw[name].state.height - raw["base"].state.height  # the pilot's wandering is equal
        at_rest = np.abs(np.gradient(flown, 1.0 / RATE)) < 0.01
        places = flown[at_rest] / step + 0.5
        assert np.mean(at_rest) > 0.3
        assert np.max(np.abs(places - np.round(places))) < 0.01
        assert set(np.round(places)) == {0.0, 1.0}
        assert np.max(np.abs(np.gradient(flown, 1.0 / RATE))) == pytest.approx(2.54, rel=0.01)


def test_the_wind_of_a_shear_is_a_straight_line_over_height(raw):
    state = raw["shear"].state
    slope = np.polyfit(state.height, state.slow_wind, 1)[0]
    assert np.hypot(*slope[:2]) == pytest.approx(0.03)
    apart = state.slow_wind[:, :2] - np.outer(state.height, slope[:2])
    assert np.max(np.ptp(apart, axis=0)) < 1e-9


def test_slow_turns_have_10_degrees_of_bank_and_turn_as_far(raw):
    roll, heading = raw["slow_turns"].columns["roll_rad"], raw["slow_turns"].state.heading
    # of a true airspeed that is not constant, from the ratio in the middle of the range
    assert np.degrees(np.quantile(np.abs(roll), 0.99)) == pytest.approx(10.0, abs=1.0)
    assert np.degrees(abs(heading[-1] - heading[0])) == pytest.approx(180.0, abs=4.0)


def test_a_probe_that_lags_forgets_within_ten_seconds(raw):
    gain = 1.0 / (10.0 * RATE)
    true = raw["probe_lag_climbs"].state
    total = true.temperature * (1.0 + 0.2 * (true.true_airspeed**2) / (401.8742 * true.temperature))
    lagged, _ = lfilter([gain], [1.0, gain - 1.0], total, zi=[(1.0 - gain) * total[0]])
    error = raw["probe_lag_climbs"].columns["total_temperature_k"] - lagged
    assert np.std(error) == pytest.approx(NOISE.temperature, rel=0.05)


def test_a_probe_that_recovers_nine_tenths_reads_low_by_a_tenth_of_the_rise(raw):
    state, columns = raw["recovery"].state, raw["recovery"].columns
    rise = 0.5 * state.true_airspeed**2 / 1004.6855  # K, over the heat of air at constant pressure
    error = columns["total_temperature_k"] - state.temperature - 0.9 * rise
    assert abs(np.mean(error)) < 4.0 * NOISE.temperature / np.sqrt(len(error))


def test_probes_are_off_to_the_side_that_the_set_says(raw):
    base = raw["base"].columns["total_temperature_k"]
    for name, off in (("probe_-20k", -20.0), ("probe_-5k", -5.0)):
        np.testing.assert_allclose(raw[name].columns["total_temperature_k"] - base, off, atol=1e-9)


def test_a_filtered_receiver_trails_in_a_turn_by_its_filter_and_its_lateness(raw):
    state, columns = raw["filtered_calm"].state, raw["filtered_calm"].columns
    late = round((0.3 + 0.2) * RATE) - 1  # the lag trails a ramp by a row less
    error = columns["velocity_north_mps"][late:] - state.ground_velocity[:-late, 0]
    assert np.std(error) < 1.2 * NOISE.velocity
    at_once = columns["velocity_north_mps"] - state.ground_velocity[:, 0]
    assert np.std(at_once) > 3.0 * NOISE.velocity


def test_a_pilot_is_off_by_what_the_kind_says():
    height, speed = [], []
    for seed in range(8):
        state = generate(RAW["pilot"], "rapid_decel", seed).state
        height.append(state.height - RAW["pilot"].height)
        level = physics.calibrated_airspeed(state.indicated_impact[: round(25.0 * RATE)]) / KNOT
        speed.append(level - 160.0)
    assert np.sqrt(np.mean(np.concatenate(height) ** 2)) / FOOT == pytest.approx(100.0, rel=0.25)
    assert np.sqrt(np.mean(np.concatenate(speed) ** 2)) == pytest.approx(5.0, rel=0.5)


def test_a_cockpit_shows_whole_units_of_what_its_sensors_read(raw):
    sensors = raw["cockpit"].columns
    shown = generate(KINDS["cockpit"], "rapid_decel", SEED).columns
    every = slice(None, None, 20)
    north, east = sensors["velocity_north_mps"][every], sensors["velocity_east_mps"][every]
    height = physics.pressure_altitude(sensors["static_pressure_pa"][every]) / FOOT
    warmth = sensors["air_temperature_k"][every] - 273.15
    for name, step, true, most in (
        ("indicated_airspeed_kt", 1.0, _airspeed(sensors["impact_pressure_pa"][every]), 0.5),
        ("pressure_altitude_ft", 10.0, height, 5.0),
        ("ground_speed_kt", 1.0, np.sqrt(north**2 + east**2) / KNOT, 0.5),
        ("air_temperature_degc", 1.0, warmth, 1.0),
    ):
        np.testing.assert_allclose(shown[name] / step, np.round(shown[name] / step), atol=1e-9)
        assert np.max(np.abs(shown[name] - true)) <= most + 1e-9
    track = np.radians(shown["track_deg"])
    astray = np.cos(track) * east - np.sin(track) * north
    assert np.max(np.abs(astray) / np.hypot(north, east)) <= np.sin(np.radians(0.5)) + 1e-9
    cut = shown["air_temperature_degc"]
    assert np.all(np.abs(cut) <= np.abs(warmth))


def test_a_barometric_height_is_that_of_the_static_pressure(raw):
    columns = generate(KINDS["barometric"], "rapid_decel", SEED).columns
    lightness = 1.0 - 0.0065 / 288.15 * columns["altitude_m"]
    pressure = 101325.0 * lightness ** (9.80665 / 287.053 / 0.0065)
    np.testing.assert_allclose(pressure, columns["static_pressure_pa"])


def test_scale_flies_the_flights_of_its_twin_and_a_third_has_a_zero(raw):
    one, twin = raw["scale"].columns, raw["scale_none"].columns
    for channel in ("static_pressure_pa", "velocity_north_mps"):
        np.testing.assert_array_equal(one[channel], twin[channel])
    dice = np.random.default_rng(1)
    drawn = [kinds.draw_scale(BASE, dice) for _ in range(3000)]
    factors = np.array([cell.impact_scale for cell in drawn])
    zeros = np.array([cell.impact_zero for cell in drawn])
    assert np.quantile(factors, [0.0, 0.5, 1.0]) == pytest.approx([0.7, 1.1, 1.5], abs=0.03)
    assert np.mean(zeros > 0.0) == pytest.approx(1.0 / 3.0, abs=0.04)
    assert np.quantile(zeros[zeros > 0.0], [0.0, 1.0]) == pytest.approx([20.0, 80.0], abs=1.0)


def test_unknowns_have_the_spread_of_their_priors():
    dice = np.random.default_rng(1)
    drawn = [kinds.draw_priors(BASE, dice) for _ in range(3000)]
    for name, spread in (
        ("probe_bias", 0.75),
        ("static_bias", 15.0),
        ("velocity_bias", 0.025),
        ("shear", 0.015),
        ("gps_late", 0.3),
        ("height_late", 0.15),
    ):
        values = np.array([getattr(cell, name) for cell in drawn])
        assert np.std(values) == pytest.approx(spread, rel=0.06), name
    gusts = np.array([cell.gust_sigma for cell in drawn])
    assert np.median(gusts) == pytest.approx(0.5, rel=0.08)
    assert np.max(gusts) == 3.0
    for values, median in (
        ([cell.gust_length for cell in drawn], 533.0),
        ([cell.slow_wind.keywords["size"] for cell in drawn], 0.4),
        ([cell.slow_wind.keywords["seconds"] for cell in drawn], 300.0),
    ):
        logs = np.log(values)
        assert np.exp(np.mean(logs)) == pytest.approx(median, rel=0.08)
        assert np.std(logs) == pytest.approx(np.log(2.5), rel=0.06)


def test_curves_of_the_priors_have_their_level_slope_and_departures():
    """Level and slope by a straight line over u; departures by their correlation at 0.7."""
    dice, low, high = np.random.default_rng(2), 100.0 * KNOT, 160.0 * KNOT
    u = np.linspace(-1.0, 1.0, 41)
    x = np.log(physics.impact_pressure(np.array([low, high])))
    at = np.exp(x.mean() + 0.5 * u * np.ptp(x))
    drawn = [physics.draw_smooth(low, high, dice) for _ in range(2000)]
    static = np.array([error.static.share(at) for error in drawn])
    total = np.array([error.total.share(at) for error in drawn])
    for shares, level, slope, rel in ((static, 0.05, 0.05, 0.06), (total, 0.005, 0.0015, 0.06)):
        lines = np.polyfit(u, shares.T, 1)
        assert np.std(lines[1]) == pytest.approx(level, rel=rel)
        assert np.std(lines[0]) == pytest.approx(slope, rel=rel)
    # a second difference has no line in it: of d at -0.7, 0, 0.7 the variance is
    # σ²(6 − 8 ρ(0.7) + 2 ρ(1.4)), and the median over sizes of its square that of the median size
    bends = static[:, 6] - 2.0 * static[:, 20] + static[:, 34]
    rho = [(1.0 + d) * np.exp(-d) for d in np.sqrt(3.0) * np.array([1.0, 2.0])]
    of_unit = np.sqrt(6.0 - 8.0 * rho[0] + 2.0 * rho[1])
    logs = np.log(np.abs(bends) / of_unit)
    # the mean of ln|N(0, 1)| is −0.6352
    assert np.exp(np.mean(logs) + 0.6352) == pytest.approx(0.002, rel=0.1)
    np.testing.assert_allclose(np.polyfit(u, total.T, 2)[0], 0.0, atol=1e-12)


def test_sixteen_seeds_of_the_priors_meet_each_maneuver_rate_and_temperature_once():
    cell = OTHERS["priors"]
    met = Counter((cell.maneuvers[seed % 16], seed % 2, seed // 2 % 2) for seed in range(16))
    assert len(met) == 16


def test_a_log_of_the_priors_is_late_by_what_its_truth_says():
    flight = generate(OTHERS["priors"], "circle", SEED)
    state, cell = flight.state, flight.cell
    time, columns = flight.columns["time_s"], flight.columns
    assert (time[0], time[-1]) == pytest.approx((2.0, state.time[-1] - 2.0))
    then = np.interp(time - cell.gps_late, state.time, state.ground_velocity[:, 0])
    error = columns["velocity_north_mps"] - then - cell.velocity_bias[0]
    assert np.std(error) == pytest.approx(NOISE.velocity, rel=0.05)
    assert abs(np.mean(error)) < 4.0 * NOISE.velocity / np.sqrt(len(error))


def test_what_is_written_is_read_by_the_product_and_is_not_written_twice(tmp_path):
    assert write_set("cockpit", range(1, 3), tmp_path) == 2
    assert write_set("cockpit", range(1, 4), tmp_path) == 1
    truth = json.loads((tmp_path / "cockpit" / "1.truth.json").read_text(encoding="utf-8"))
    assert (truth["set"], truth["seed"], truth["maneuver"]) == ("cockpit", 1, "rapid_decel")
    log = read_log(tmp_path / "cockpit" / "1.csv")
    flight = generate(RAW["cockpit"], "rapid_decel", 1)
    np.testing.assert_allclose(log.time, flight.state.time[::20])
    impact = flight.columns["impact_pressure_pa"][::20]
    assert np.max(np.abs(_airspeed(log.impact_pressure) - _airspeed(impact))) < 0.51
