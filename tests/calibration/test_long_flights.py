"""Long flights: the parts used, the windows of a drifting wind, height alone, and what contradicts
itself.
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import static_flights as fixture
from tests.shared_data import real_log

from pitotbench import CalibrationOptions, FlightLog, NoAnswerError, air, read_log
from pitotbench.bench.inspection import inspect_log
from pitotbench.calibration import calibrate, calibrate_flights
from pitotbench.calibration.fit_checks import disagreements, with_points
from pitotbench.calibration.observations import ENDS, GROUND, STEEP, spans, usable_parts
from pitotbench.channels import CHANNELS
from pitotbench.logbook.columns import Table
from pitotbench.logbook.reading import log_of
from pitotbench.records.calibration import ErrorCurve, Residuals
from pitotbench.records.legs import FixedSpeedPoint
from pitotbench.units import KNOT

CHECKED = CalibrationOptions(wind="checked")
HOUR, RATE = 3600.0, 2
CURVE = -0.06  # Δp/q_c of the long flight


def usual_wind(time):
    return 5.0 + 6.0 * time / HOUR, -4.0 * np.sin(2.0 * np.pi * time / HOUR)


def circling(seconds=HOUR, wind=usual_wind, seed=3):
    """A flight that turns once in four minutes at slowly changing airspeeds, carried by a wind of
    the time.
    """
    rng, time = np.random.default_rng(seed), np.arange(0.0, seconds, 1.0 / RATE)
    height = 1500.0 + 100.0 * np.sin(time / 400.0)
    static = np.asarray(air.standard_pressure(height))
    temperature = 288.15 - 0.0065 * height
    speed = (60.0 + 12.0 * np.sin(time / 700.0)) + 0.4 * rng.standard_normal(len(time))
    impact = np.asarray(air.impact_pressure_from_mach(speed / air.sound_speed(temperature), static))
    heading = 2.0 * np.pi * time / 240.0
    north, east = wind(time)
    return FlightLog(
        time=time,
        impact_pressure=impact * (1.0 - CURVE) + 4.0 * rng.standard_normal(len(time)),
        static_pressure=static + 4.0 * rng.standard_normal(len(time)),
        air_temperature=temperature,
        velocity_north=speed * np.cos(heading) + north + 0.05 * rng.standard_normal(len(time)),
        velocity_east=speed * np.sin(heading) + east + 0.05 * rng.standard_normal(len(time)),
    )


def on_the_ground(log, before, after):
    """The log with rest before a take-off roll and after a landing roll, of so many seconds each."""
    parts = []
    for seconds, edge, growing in ((before, 0, True), (after, -1, False)):
        n = int(seconds * RATE)
        roll = np.clip(np.linspace(-1.0, 1.0, n), 0.0, None)
        share = roll if growing else roll[::-1]
        held = {name: np.full(n, values[edge]) for name, values in log.channels().items()}
        held["impact_pressure"] = held["impact_pressure"] * share**2
        held["velocity_north"], held["velocity_east"] = 0.8 * 60.0 * share, np.zeros(n)
        parts.append(held)
    joined = {
        name: np.concatenate([parts[0][name], values, parts[1][name]])
        for name, values in log.channels().items()
    }
    joined["time"] = np.arange(len(joined["time"])) / RATE
    return FlightLog(**joined)


def test_ground_and_ends_are_left_out_and_told():
    flown = circling(1200.0)
    log = on_the_ground(flown, 200.0, 150.0)
    parts = usable_parts(log)
    assert parts.reasons == (GROUND, ENDS)
    ((begin, end),) = spans(log.time, parts.rows)
    assert begin == pytest.approx(200.0 + 60.0, abs=60.0)
    assert end == pytest.approx(200.0 + 1200.0 - 120.0, abs=60.0)
    found = calibrate(log, CHECKED)
    assert found.parts == ((begin, end),)
    assert found.left_out == (GROUND, ENDS)
    assert float(found.residuals.time.min()) >= begin


def test_steep_flight_is_left_out_and_neither_maneuvers_nor_a_spike_are():
    assert usable_parts(fixture.fly("circle")).rows.all()
    log = circling(600.0)
    pressure = log.static_pressure.copy()
    pressure[::97] += 2000.0
    for static in (log.static_pressure, pressure):
        assert usable_parts(replace(log, static_pressure=static)).rows.all()
    dive = log.static_pressure + np.clip(log.time - 300.0, 0.0, 40.0) * 150.0  # 13 m/s at 60
    parts = usable_parts(replace(log, static_pressure=dive))
    assert parts.reasons == (STEEP,)
    assert not parts.rows[(log.time > 305.0) & (log.time < 335.0)].any()


def test_an_hour_has_a_wind_for_each_window_and_one_curve():
    log = circling()
    found = calibrate(log, CHECKED)
    assert np.all(correction_error(found.curve) <= found.curve.two_sigma)
    assert len(found.winds) == 6
    for window in found.winds:
        time = log.time[(log.time >= window.begin) & (log.time <= window.end)]
        for axis, wind in zip(("north", "east"), usual_wind(time), strict=True):
            estimate = getattr(window, axis)
            assert abs(estimate.value - wind.mean()) <= 1.5 * estimate.two_sigma < 3.0


def correction_error(curve):
    q = np.asarray(air.impact_pressure(curve.indicated_airspeed))
    true = np.asarray(air.calibrated_airspeed(q / (1.0 - CURVE))) - curve.indicated_airspeed
    return np.abs(curve.correction - true)


def test_a_long_flight_is_not_asked_for_one_wind():
    """Neither the reader nor the account: each part of a wave flight has a wind of its own."""

    def wave(t):
        return 25.0 * np.sin(2.0 * np.pi * t / HOUR), 20.0 * np.cos(2.0 * np.pi * t / HOUR)

    log = circling(1.5 * HOUR, wave)
    columns = {CHANNELS[name].column: values for name, values in log.channels().items()}
    read = log_of(Table(tuple(columns), tuple(columns.values()), {}, ()))
    assert "warnings" not in read.header
    assert inspect_log(read).wind_drifts
    assert not inspect_log(circling(600.0)).wind_drifts


def test_height_alone_answers_for_one_heading():
    log = fixture.one_heading(fixture.fly("step_decrease", 2))
    options = CalibrationOptions(model="linear", wind="checked")
    found = calibrate(log, options)
    assert found.wind is None
    assert found.method == "height"
    assert found.winds == ()
    true = fixture.true_correction(found.curve.indicated_airspeed)
    assert np.all(np.abs(found.curve.correction - true) < found.curve.two_sigma)
    assert any("the wind is unknown" in warning for warning in found.warnings)
    assert calibrate_flights([log], options)[0].calibration.curve.correction == pytest.approx(
        found.curve.correction
    )
    with pytest.raises(NoAnswerError, match="all headings lie within"):
        calibrate(replace(log, altitude=None), options)


def test_height_alone_at_one_airspeed_holds_what_the_wind_triangle_says():
    log = read_log(real_log("garmin", "pa28-gifd-2024.csv.gz"))
    smooth = replace(CHECKED, model="smooth")
    minutes = (log.time - log.start) / 60.0
    cruise, turns = (
        calibrate(log.part((minutes > first) & (minutes < first + 20.0)), smooth).curve
        for first in (140.0, 60.0)
    )
    speed = 114.0 * KNOT
    (by_height, bound), (by_wind, own) = (
        [np.interp(speed, curve.indicated_airspeed, y) for y in (curve.correction, curve.two_sigma)]
        for curve in (cruise, turns)
    )
    assert abs(by_height - by_wind) < np.hypot(bound, own)


def test_without_a_height_the_altitude_error_is_assumed_and_its_bound_holds_zero():
    found = calibrate(fixture.without_height(fixture.fly("circle", 2)), CHECKED)
    assert found.place_assumed
    assert np.all(np.abs(found.curve.altitude_correction) <= found.curve.altitude_two_sigma)
    assert not calibrate(fixture.fly("circle", 2), CHECKED).place_assumed


def _curve(bound):
    speed = np.array([90.0, 130.0]) * KNOT
    flat = np.full(2, bound)
    return ErrorCurve(speed, np.zeros(2), flat, flat, flat, np.zeros(2), flat)


@pytest.mark.parametrize(("off", "bound", "found"), [(0.0, 0.2, 0), (1.5, 0.2, 1), (1.5, 3.0, 0)])
def test_samples_far_from_the_curve_say_do_not_use(off, bound, found):
    rng, time = np.random.default_rng(1), np.arange(0.0, 600.0, 0.5)
    speed = np.linspace(92.0, 128.0, len(time)) * KNOT
    airspeed = 0.5 * rng.standard_normal(len(time)) + np.where(speed > 120.0 * KNOT, off, 0.0)
    residuals = Residuals(time, speed + airspeed, airspeed, np.ones(len(time), dtype=bool))
    told = disagreements(None, residuals, _curve(bound))
    assert len(told) == found
    assert all(each.kind == "samples" and each.fatal for each in told)


@pytest.mark.parametrize(("moves", "told"), [(0.1, 0), (-0.6, 1), (2.0, 1)])
def test_a_height_is_told_in_knots_where_it_moves_the_curve_by_a_quarter_of_the_bound(moves, told):
    time = np.arange(0.0, 60.0)
    speed = np.full(len(time), 110.0) * KNOT
    residuals = Residuals(time, speed, np.zeros(len(time)), np.ones(len(time), dtype=bool))
    by_height = np.array([[0.5, 0.5], [0.5, 0.5 + moves]]) * KNOT
    found = disagreements(1e-6, residuals, _curve(1.0 * KNOT), by_height=[*by_height])
    assert len(found) == told
    for each in found:
        assert each.kind == "height"
        assert f"at 130 KIAS from +0.5 to {0.5 + moves:+.1f} kt" in each.words
        assert each.size == pytest.approx(abs(moves) * KNOT)
    assert not disagreements(0.5, residuals, _curve(1.0 * KNOT), by_height=[*by_height])


@pytest.mark.parametrize(("correction", "told"), [(0.5, []), (6.0, ["fixed_speed"])])
def test_a_fixed_speed_point_far_from_the_curve_is_told(correction, told):
    found = calibrate(fixture.fly("circle", 2), CHECKED)
    middle = len(found.curve.correction) // 2
    speed, value, bound = (part[middle] for part in (
        found.curve.indicated_airspeed, found.curve.correction, found.curve.two_sigma,
    ))  # fmt: skip
    point = FixedSpeedPoint(
        method="three_leg", legs=3, seconds=90.0, indicated_airspeed=speed, calibrated_airspeed=speed + value,
        correction=value + correction * bound, two_sigma=bound, true_airspeed=60.0, true_airspeed_two_sigma=0.1,
        spread=None, wind_north=0.0, wind_east=0.0, wind_two_sigma=1.0,
    )  # fmt: skip
    assert [each.kind for each in with_points(found, [point]).disagreements] == told
    assert with_points(found, [point]).usable


def test_the_c172s_of_a_whole_hour_agrees_with_its_handbook():
    """Pilot's Operating Handbook, flaps up: 100 KIAS are 97 KCAS, 110 are 107, ±3 kt for one
    airplane.
    """
    found = calibrate(read_log(real_log("garmin", "c172s-g1000-2011.csv.gz")), CHECKED)
    indicated = np.array([60.0, 70.0, 80.0, 90.0, 100.0, 110.0])
    handbook = np.array([2.0, 0.0, -2.0, -3.0, -3.0, -3.0])
    value, bound = (
        np.interp(indicated, found.curve.indicated_airspeed_kt, of)
        for of in (found.curve.correction_kt, found.curve.two_sigma_kt)
    )
    assert np.all(np.abs(value - handbook) <= np.hypot(bound, 3.0))
    assert np.all(bound[indicated > 95.0] <= 4.0)
    assert found.usable
    assert len(found.winds) > 3


@pytest.mark.parametrize("name", ["CLASS55", "CLASS65"])
def test_height_alone_agrees_with_a_balloon(name):
    """Δp/q_c by the balloon's pressure at GPS height: 0.035 to 0.037 at 340 KIAS; 0.5 hPa are its
    own doubt.
    """
    log = read_log(real_log("jmoss", f"{name}.csv"), "jmoss")
    track = np.unwrap(np.arctan2(log.velocity_east, log.velocity_north))
    start = min(range(0, len(log) - 2000, 500), key=lambda row: np.ptp(track[row : row + 2000]))
    options = CalibrationOptions(model="auto", error_location="static", wind="drifting", mach_max=0.9,
                                 accuracies={"temperature_k": 5.0})  # fmt: skip
    found = calibrate(log.select(np.arange(start, start + 2000)), options)
    assert found.wind is None
    middle = len(found.curve.correction) // 2
    bound = np.hypot(
        found.curve.normalized_two_sigma, 50.0 / air.impact_pressure(found.curve.indicated_airspeed)
    )
    assert abs(found.curve.normalized_pressure_error[middle] - 0.036) <= bound[middle]
