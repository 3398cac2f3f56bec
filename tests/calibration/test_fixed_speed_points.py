"""Fixed-speed points: worked examples, recovery of a known answer, the bound over many flights,
refusals.
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import BadInputError, CalibrationOptions, NoAnswerError, air, fixed_speed, sense
from pitotbench.calibration.leg_methods import circle_fit
from pitotbench.calibration.leg_points import block_means, cross_check, fixed_speed_points
from pitotbench.calibration.observations import observe
from pitotbench.calibration.options import Accuracies
from pitotbench.campaigns.flights import true_correction, wind_toward
from pitotbench.units import DEGREE, KNOT

RATE = 10


def legs_path(*headings_deg, speeds_kt=(110.0, 140.0), seconds=20):
    """Legs joined by turns at standard rate, once a speed; speed changes on the last heading."""
    speed, heading = [], []
    for fast in speeds_kt:
        for here, there in zip(headings_deg, (*headings_deg[1:], headings_deg[-1]), strict=True):
            turn = np.linspace(here, there, max(1, round(abs(there - here) / 3.0 * RATE)))
            heading += [np.full(seconds * RATE, here), turn]
            speed += [np.full(seconds * RATE, fast), np.full(len(turn), fast)]
        speed.append(np.linspace(fast, fast + 30.0, 30 * RATE))
        heading.append(np.full(30 * RATE, headings_deg[-1]))
    return np.concatenate(speed) * KNOT, np.concatenate(heading) * DEGREE


def circle_path(speed_kt=120.0, seconds=90):
    return np.full(seconds * RATE, speed_kt) * KNOT, np.linspace(
        0.0, 400.0, seconds * RATE
    ) * DEGREE


def test_a_wrong_time_stamp_takes_no_memory():
    """A step of 1e12 s within a run: the seconds without rows are not counted one by one."""
    log = fixture.fly(circle_path(), RATE, RATE, fixture.Air())
    obs = observe(log, CalibrationOptions())
    late = replace(obs, time=obs.time + np.where(np.arange(len(obs)) < len(obs) // 2, 0.0, 1e12))
    usual, spoiled = block_means(log, obs), block_means(log, late)
    assert len(spoiled.time) == pytest.approx(len(usual.time), abs=1)
    np.testing.assert_array_equal(spoiled.ground_speed[:40], usual.ground_speed[:40])


def error_kt(point):
    return (
        point.correction - fixture.true_correction(np.array([point.indicated_airspeed]))[0]
    ) / KNOT


@pytest.mark.parametrize(
    ("path", "method", "count"),
    [
        (legs_path(0, 90, 180, 270), "four_leg", 2),
        (legs_path(0, 120, 240), "three_leg", 2),
        (legs_path(0, 72, 144, 216, 288), "many_leg", 2),
        (circle_path(), "turn", 1),
    ],
)
def test_legs_and_turns_are_found_and_recover_curve_and_wind(path, method, count):
    points = fixed_speed_points(fixture.fly(path, RATE, RATE, fixture.CALM))
    assert [point.method for point in points] == [method] * count
    for point in points:
        assert error_kt(point) == pytest.approx(0.0, abs=0.01)
        assert (point.wind_north, point.wind_east) == pytest.approx(fixture.WIND, abs=0.01)


def test_three_legs_on_square_tracks_have_one_answer():
    """Tracks 90° apart are no case of their own: the circle through three velocities is exact there."""
    windy = fixture.fly(legs_path(0, 90, 180), RATE, RATE, fixture.CALM)
    north, east = (windy.velocity_north - fixture.WIND[0], windy.velocity_east - fixture.WIND[1])
    points = fixed_speed_points(replace(windy, velocity_north=north, velocity_east=east))
    assert [point.method for point in points] == ["three_leg"] * 2
    assert [error_kt(point) for point in points] == pytest.approx([0.0, 0.0], abs=0.01)


def test_labels_are_believed():
    """Only what is on condition counts: here two seconds of every leg, too short to be one."""
    log = fixture.fly(legs_path(0, 90, 180, 270, seconds=20), RATE, RATE, fixture.CALM)
    on = np.zeros(len(log), dtype=np.bool_)
    on[:: 20 * RATE] = True
    on = np.convolve(on, np.ones(2 * RATE), mode="same") > 0
    with pytest.raises(NoAnswerError):
        fixed_speed_points(replace(log, on_condition=on))


@pytest.mark.parametrize("path", [legs_path(0, 90, 180, 270), circle_path()])
def test_the_bound_covers_and_is_not_idle(path):
    """40 or 20 points in gusts: at least 80 % inside 2σ (95 less three standard errors), 2σ below 4
    times rms.
    """
    found = [
        p
        for seed in range(20)
        for p in fixed_speed_points(fixture.fly(path, RATE, RATE, fixture.Air(), seed))
    ]
    error, bound = np.array([[error_kt(point), point.two_sigma / KNOT] for point in found]).T
    assert np.mean(np.abs(error) <= bound) >= 0.80
    assert bound.mean() <= 4.0 * np.sqrt(np.mean(error**2))


def test_a_static_source_error_is_taken_from_the_static_pressure():
    """q_ci = q − Δp and p_i = p + Δp: total pressure is right, and 10 % of q come back as the
    correction.
    """
    log = fixture.fly(circle_path(), RATE, RATE, fixture.CALM)
    impact = fixture.TRUTH.impact_pressure(log.impact_pressure)
    pressure_error = 0.1 * impact
    wrong = replace(
        log,
        impact_pressure=impact - pressure_error,
        static_pressure=log.static_pressure + pressure_error,
    )
    (point,) = fixed_speed_points(wrong, CalibrationOptions(error_location="static"))
    expected = air.calibrated_airspeed(impact.mean()) - air.calibrated_airspeed(0.9 * impact.mean())
    assert point.correction == pytest.approx(float(expected), abs=0.01 * KNOT)
    (missed,) = fixed_speed_points(wrong, CalibrationOptions(error_location="impact"))
    assert abs(missed.correction - expected) > 0.1 * KNOT


def test_a_circle_of_the_simulator_agrees_with_its_truth(smooth_flights):
    """Means of a turning vector over a second would be 0.03 kt short: they must not be used."""
    flight = smooth_flights["circle"]
    points = fixed_speed_points(sense(flight, "50/50"))
    speeds = np.array([point.indicated_airspeed for point in points])
    error = np.array([point.correction for point in points])
    error -= true_correction(flight.case.pressure_error, speeds)
    assert len(points) == 4
    assert np.all(np.abs(error) < 0.02 * KNOT)
    wind = wind_toward(flight.case.wind)
    assert all(abs(point.wind_north - wind[0]) < 0.03 * KNOT for point in points)


@pytest.mark.parametrize(
    "path", [fixture.straight(RATE), fixture.step_decrease(RATE), legs_path(0, 180)]
)
def test_logs_without_three_tracks_or_a_turn_are_refused_with_what_to_fly(path):
    log = fixture.fly(path, RATE, RATE, fixture.CALM)
    with pytest.raises(NoAnswerError, match="fly four legs 90° apart"):
        fixed_speed_points(log)
    assert cross_check(log) == ()


@pytest.mark.parametrize("location", ["impact", "static"])
@pytest.mark.parametrize(
    ("channel", "name", "off"),
    [("total_temperature", "temperature_k", 1.0), ("static_pressure", "static_pressure_pa", 40.0)],
)
def test_a_stated_accuracy_widens_the_bound_by_what_such_an_error_does(
    channel, name, off, location
):
    """The log with that very error moves the correction by the share, which adds to the bound as a
    square.
    """
    log = fixture.fly(legs_path(0, 90, 180, 270), RATE, RATE, fixture.Air())
    wrong = replace(log, **{channel: getattr(log, channel) + off})
    options = CalibrationOptions(error_location=location, accuracies=Accuracies(**{name: off}))
    plain = fixed_speed_points(log, replace(options, accuracies=Accuracies()))
    shifted, widened = fixed_speed_points(wrong, options), fixed_speed_points(log, options)
    for here, there, wide in zip(plain, shifted, widened, strict=True):
        moved = there.correction - here.correction
        assert abs(moved) > 0.005 * KNOT
        assert wide.two_sigma == pytest.approx(np.hypot(here.two_sigma, moved), rel=0.02)
        assert wide.correction == here.correction


@pytest.mark.parametrize("location", ["impact", "static"])
def test_a_zero_offset_belongs_to_the_correction_and_hardly_widens_it(location):
    """Raw reading plus correction is the calibrated airspeed, whatever the offset: GPS does not
    feel it.
    """
    log = fixture.fly(legs_path(0, 90, 180, 270), RATE, RATE, fixture.Air())
    raw = replace(log, impact_pressure=log.impact_pressure + 60.0)
    options = CalibrationOptions(
        error_location=location, accuracies=Accuracies(impact_pressure_zero_pa=400.0)
    )
    plain = fixed_speed_points(log, replace(options, accuracies=Accuracies()))
    for here, there in zip(plain, fixed_speed_points(raw, options), strict=True):
        assert there.indicated_airspeed - here.indicated_airspeed > 0.5 * KNOT
        assert there.calibrated_airspeed == pytest.approx(here.calibrated_airspeed, abs=0.1 * KNOT)
        assert there.two_sigma < here.two_sigma + 0.5 * KNOT


def test_accuracies_of_the_header_and_of_a_standard_day_count():
    log = fixture.fly(circle_path(), RATE, RATE, fixture.CALM)
    warm = replace(log, header={"accuracy": {"temperature_k": 15.0}})
    logs = (log, warm, replace(log, total_temperature=None))
    (plain,), (stated,), (unmeasured,) = (fixed_speed_points(each) for each in logs)
    assert plain.two_sigma < 0.05 * KNOT < 1.0 * KNOT < stated.two_sigma
    assert unmeasured.two_sigma == pytest.approx(stated.two_sigma, rel=0.1)


def test_an_error_of_ground_velocity_goes_to_the_wind():
    log = fixture.fly(circle_path(), RATE, RATE, fixture.CALM)
    (plain,) = fixed_speed_points(log)
    (moved,) = fixed_speed_points(replace(log, velocity_north=log.velocity_north + 0.5))
    (wide,) = fixed_speed_points(log, CalibrationOptions(accuracies=Accuracies(velocity_mps=0.5)))
    assert moved.correction == pytest.approx(plain.correction, abs=1e-3)
    assert wide.two_sigma == plain.two_sigma
    assert wide.wind_two_sigma == pytest.approx(
        np.hypot(plain.wind_two_sigma, moved.wind_north - plain.wind_north), rel=1e-3
    )


def test_circle_fit_is_exact_on_a_circle_and_agrees_with_three_legs():
    angle = np.array([0.3, 1.9, 3.0, 4.4, 6.0])
    velocity = 60.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1) + [4.0, -7.0]
    assert circle_fit(velocity) == pytest.approx([60.0, 4.0, -7.0], rel=1e-9)
    rough = velocity[:3] + np.array([[0.4, -0.1], [-0.3, 0.2], [0.1, 0.5]])
    three = fixed_speed(np.linalg.norm(rough, axis=1), np.arctan2(rough[:, 1], rough[:, 0]))
    assert circle_fit(rough)[0] == pytest.approx(three.true_airspeed, rel=1e-9)


@pytest.mark.parametrize(
    ("speeds_kt", "tracks_deg", "error", "says"),
    [
        ([120, 121, 120], [90, 90, 90], NoAnswerError, "60°"),
        ([120, 130], [0, 90], BadInputError, None),
        ([120, -1, 130], [0, 90, 180], BadInputError, None),
    ],
)
def test_legs_that_determine_nothing_are_refused(speeds_kt, tracks_deg, error, says):
    with pytest.raises(error, match=says):
        fixed_speed(np.array(speeds_kt) * KNOT, np.array(tracks_deg) * DEGREE)
    with pytest.raises(NoAnswerError, match="full"):
        circle_fit(np.outer(np.linspace(59.0, 61.0, 9), [1.0, 0.0]))
