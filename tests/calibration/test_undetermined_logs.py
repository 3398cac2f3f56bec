"""Logs that do not determine an answer get none, and the message says what to fly."""

from dataclasses import fields, replace

import numpy as np
import pytest
from tests.calibration import static_flights
from tests.calibration import trajectories as fixture

from pitotbench import BadInputError, CalibrationOptions, NoAnswerError
from pitotbench.calibration import calibrate
from pitotbench.units import KNOT


def test_one_heading_or_one_speed_does_not_carry_three_parameters():
    with pytest.raises(NoAnswerError, match="headings lie within"):
        calibrate(fixture.fly(fixture.straight(10), 10, 10, fixture.Air()))
    speed, heading = fixture.step_decrease(10)
    log = fixture.fly(
        (np.full_like(speed, 120.0 * KNOT), heading), 10, 10, fixture.Air(pressure=1.0, gust=0.1)
    )
    with pytest.raises(NoAnswerError, match="--model bias"):
        calibrate(log)
    assert calibrate(log, CalibrationOptions(model="bias")).converged


def _legs(*headings_deg):
    """A sweep of speed on each heading, without the turns between them."""
    speed, heading = fixture.straight(10)
    return np.tile(speed, len(headings_deg)), np.repeat(np.deg2rad(headings_deg), len(heading))


def test_the_advice_to_reciprocal_legs_helps():
    """Each step that the refusals advise has not been flown yet, and the last one has an answer."""
    for flown in ([0.0], [0.0, 180.0], [0.0, 180.0, 0.0, 180.0]):
        with pytest.raises(NoAnswerError, match="three headings at least 60° apart") as found:
            calibrate(fixture.fly(_legs(*flown), 10, 10, fixture.Air()))
        assert "reciprocal" not in str(found.value)
    found = calibrate(fixture.fly(_legs(0.0, 180.0, 90.0), 10, 10, fixture.Air()))
    assert np.median(found.curve.two_sigma) < 1.0 * KNOT


@pytest.mark.parametrize(
    ("changes", "options", "says"),
    [
        ({"impact_pressure": 5.0}, {}, "usable"),
        ({"velocity_north": 60.0, "velocity_east": 60.0, "gps_fresh": None}, {}, "GPS"),
        ({}, {"on_condition": True}, "on_condition"),
    ],
    ids=["standing still", "stuck GPS", "no column on_condition"],
)
def test_a_log_without_what_is_needed_is_bad_input(changes, options, says):
    log = fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air())
    filled = {
        name: value if value is None else np.full(len(log), value)
        for name, value in changes.items()
    }
    with pytest.raises(BadInputError, match=says):
        calibrate(replace(log, **filled), CalibrationOptions(**options))


def _in_knots_from_the_middle(log):
    factor = np.where(np.arange(len(log)) < len(log) // 2, 1.0, 1.0 / KNOT)
    return replace(
        log, velocity_north=factor * log.velocity_north, velocity_east=factor * log.velocity_east
    )


def _in_any_order(log):
    order = np.random.default_rng(1).permutation(len(log))
    channels = {f.name: getattr(log, f.name) for f in fields(log) if f.name != "time"}
    return replace(log, **{k: v[order] for k, v in channels.items() if isinstance(v, np.ndarray)})


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda log: replace(log, time=log.time / 3600.0), "unit of the time"),
        (lambda log: replace(log, time=log.time / 1000.0), "unit of the time"),
        (
            lambda log: replace(log, velocity_east=np.zeros(len(log))),
            "toward east is zero in every row",
        ),
        (_in_any_order, "check the clock"),
        (_in_knots_from_the_middle, "units"),
    ],
    ids=["hours", "milliseconds", "no east velocity", "rows in any order", "knots from the middle"],
)
@pytest.mark.parametrize("wind", ["constant", "drifting"])
def test_a_wrong_clock_or_velocity_gets_a_reason_and_no_answer(spoil, reason, wind):
    log = fixture.fly(_round_and_round(20), 20, 1, fixture.Air())
    with pytest.raises(NoAnswerError, match=reason):
        calibrate(spoil(log), CalibrationOptions(wind=wind, latency="checked"))


def _round_and_round(rate):
    """Four turns, each at its speed."""
    speed, heading = (
        np.repeat([160.0, 140.0, 120.0, 100.0], 120 * rate),
        np.linspace(0.0, 1440.0, 480 * rate),
    )
    return speed * KNOT, np.deg2rad(heading)


@pytest.mark.parametrize("choice", [{"method": "papre"}, {"error_location": "pitot"}])
def test_unknown_choices_name_the_known(choice):
    with pytest.raises(BadInputError, match="Known"):
        CalibrationOptions(**choice)


def test_a_curve_that_is_doubtfully_large_warns_and_one_of_a_unit_is_not_to_be_used():
    log = fixture.fly(fixture.circles(10), 10, 10, fixture.Air(gust=0.1))
    assert not calibrate(log).warnings
    strong = replace(log, impact_pressure=0.85 * log.impact_pressure)
    assert any(
        "certified airplane's is smaller" in warning for warning in calibrate(strong).warnings
    )
    fast = replace(
        log, velocity_north=log.velocity_north / KNOT, velocity_east=log.velocity_east / KNOT
    )
    found = calibrate(fast)
    assert not found.usable
    assert found.scale.factor == pytest.approx(1.0 / KNOT, abs=found.scale.two_sigma)
    assert any("GPS velocity in knots" in meaning for meaning in found.scale.units)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda log: replace(log, velocity_east=np.minimum(log.velocity_east, 20.0)),
        lambda log: replace(
            log, velocity_east=log.velocity_east + np.where(log.time < 200.0, 0.0, 10.0)
        ),
    ],
    ids=["clipped", "jumps by 10 m/s"],
)
def test_nobody_is_sent_to_fly_other_headings_where_all_were_flown(spoil):
    log = fixture.fly(fixture.circles(5), 5, 5, fixture.Air(gps=0.02, pressure=2.0), seed=7)
    with pytest.raises(NoAnswerError, match="air data and GPS velocity disagree") as found:
        calibrate(spoil(log))
    assert "fly" not in str(found.value)


def test_a_log_of_a_steep_climb_is_told_that_it_holds_no_level_flight():
    log = static_flights.fly("circle", 3)
    climbed = log.static_pressure - 130.0 * (log.time - log.time[0])  # 14 m/s up at 60 to 80
    with pytest.raises(BadInputError, match="no level flight of 30 s in this log, which climbs"):
        calibrate(replace(log, static_pressure=climbed), CalibrationOptions())
