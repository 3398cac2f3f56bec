"""The check for a wind that changed: what it names, what it leaves alone."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.calibration import static_flights as flights

from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.records.log import Caution
from pitotbench.units import DEGREE

CHECKED, CONSTANT = CalibrationOptions(wind="checked"), CalibrationOptions(wind="constant")


def flown(maneuver, seed, change=None, with_heading=True, gust=0.5):
    """A flight in gusts, with its heading to 0.5°, carried by a wind that changes with time [m/s
    north, east].
    """
    log = flights.fly(maneuver, seed, conditions=flights.Conditions(gust=gust))
    heading = None
    if with_heading:
        rng = np.random.default_rng(seed)
        air = np.stack([log.velocity_north - flights.WIND[0], log.velocity_east - flights.WIND[1]])
        heading = (
            np.arctan2(air[1], air[0]) + 2.0 * DEGREE + 0.5 * DEGREE * rng.standard_normal(len(log))
        )
    if change is None:
        return replace(log, heading=heading)
    fix = np.maximum.accumulate(np.where(log.gps_fresh, np.arange(len(log)), 0))
    north, east = (part[fix] for part in change(log.time))
    moved = {
        "velocity_north": log.velocity_north + north,
        "velocity_east": log.velocity_east + east,
    }
    return replace(log, heading=heading, **moved)


def front(middle, north, east):
    """A change within 20 s."""

    def change(time):
        step = np.clip((time - middle) / 20.0 + 0.5, 0.0, 1.0)
        return north * step, east * step

    return change


@cache
def fitted(maneuver, seed, options, moved=False):
    """The calibration of a flight in a steady wind, or in one that a front moves by 4 m/s."""
    change = front(150.0, 2.8, 2.8) if moved else None
    return calibrate(flown(maneuver, seed, change), options)


def named(result):
    return [warning for warning in result.warnings if "the wind may have changed" in warning]


def test_a_wind_that_changes_with_the_heights_flown_is_not_the_error_of_the_airspeed():
    # The pilot wanders by 40 m (rms); 0.03 m/s a meter makes 1.2 m/s of it.
    log = flights.fly("step_decrease", 3, conditions=flights.Conditions(gust=0.2, wander=40.0))
    fix = np.maximum.accumulate(np.where(log.gps_fresh, np.arange(len(log)), 0))
    shear = 0.03 * (log.altitude - np.mean(log.altitude))[fix]
    moved = {
        "velocity_north": log.velocity_north + shear,
        "velocity_east": log.velocity_east - shear,
    }
    still, found = (calibrate(each, CHECKED).curve for each in (log, replace(log, **moved)))
    assert np.all(np.abs(found.correction - still.correction) < 0.5 * found.two_sigma)


@pytest.mark.parametrize("maneuver", ["step_decrease", "rapid_decel"])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_front_is_named_by_its_size_where_each_speed_is_flown_once(maneuver, seed):
    found = fitted(maneuver, seed, CHECKED, moved=True)
    assert len(named(found)) == 1
    assert found.diagnostics.wind_change.size == pytest.approx(4.0, abs=1.5)


def test_the_heading_is_what_shows_it():
    unseen = flown("step_decrease", 1, front(150.0, 2.8, 2.8), with_heading=False)
    found = fitted("step_decrease", 1, CHECKED, moved=True), calibrate(unseen, CHECKED)
    evidence = [each.diagnostics.wind_change.bayes_factor for each in found]
    assert evidence[0] > 10.0 * evidence[1]


def test_a_steady_wind_costs_hardly_any_width():
    for maneuver in ("circle", "step_decrease"):
        checked, constant = (fitted(maneuver, 1, each).curve for each in (CHECKED, CONSTANT))
        # A shear that the log hardly shows may make the gusts a little smaller.
        assert np.all(checked.two_sigma > 0.95 * constant.two_sigma)
        assert np.mean(checked.two_sigma) < 1.15 * np.mean(constant.two_sigma)


@pytest.mark.parametrize("seed", [1, 2])
def test_the_bound_holds_the_curve_that_a_front_moves(seed):
    steady = fitted("step_decrease", seed, CONSTANT).curve
    moved = {
        each.wind: fitted("step_decrease", seed, each, moved=True).curve
        for each in (CONSTANT, CHECKED)
    }
    off = {
        name: np.abs(curve.correction - steady.correction) / curve.two_sigma
        for name, curve in moved.items()
    }
    assert np.max(off["constant"]) > 1.5
    assert np.max(off["checked"]) < 1.0


def test_the_mixture_of_models_is_averaged_over_changes_of_the_wind_too():
    """The bound holds what a front moves, and costs little where the wind was steady."""
    auto = replace(CHECKED, model="auto")
    right = fitted("step_decrease", 1, CONSTANT).curve
    moved = fitted("step_decrease", 1, auto, moved=True).curve
    assert np.max(np.abs(moved.correction - right.correction) / moved.two_sigma) < 1.0
    widths = [
        np.mean(fitted("step_decrease", 1, each).curve.two_sigma)
        for each in (auto, replace(auto, wind="constant"))
    ]
    assert 0.95 < widths[0] / widths[1] < 1.2


def test_a_heading_that_is_off_or_follows_the_speed_is_no_change_of_the_wind():
    """A compass with 8° of variation left in, and a trim that turns the nose by 2° over the speeds."""
    log = flown("step_decrease", 3)
    share = log.impact_pressure / float(np.median(log.impact_pressure)) - 1.0
    off = replace(log, heading=log.heading + 8.0 * DEGREE + 2.0 * DEGREE * share)
    assert not named(calibrate(off, CHECKED))


@pytest.mark.parametrize("latency", ["checked", "estimated"])
def test_a_late_gps_is_not_called_a_magnetic_compass(latency):
    """In a circle the track of a late GPS lags behind the heading by turn rate times delay."""
    log = flown("circle", 2)
    rate = float(np.degrees(np.mean(np.diff(np.unwrap(log.heading))))) / 0.05
    late = {name: np.r_[np.full(20, getattr(log, name)[0]), getattr(log, name)[:-20]]
            for name in ("velocity_north", "velocity_east")}  # fmt: skip
    for size, kept in ((-rate * 1.0, False), (rate * 1.0, True), (-rate * 4.0, True)):
        told = Caution("the axes are turned", "axes turned", "heading", size)
        header = {**log.header, "warnings": [told]}
        moved = replace(log, gps_fresh=np.roll(log.gps_fresh, 20), header=header, **late)
        found = calibrate(moved, CalibrationOptions(latency=latency))
        assert (told in found.warnings) == kept
