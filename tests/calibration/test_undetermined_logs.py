"""Logs that do not determine an answer get none, and the message says what to fly."""

from dataclasses import fields, replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.catalog import UnknownNameError
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.units import KNOT


def test_one_heading_is_not_observable():
    log = fixture.fly(fixture.straight(10), 10, 10, fixture.Air())
    with pytest.raises(NoAnswerError, match="headings lie within"):
        calibrate(log)


def test_one_speed_does_not_carry_three_parameters():
    speed, heading = fixture.step_decrease(10)
    log = fixture.fly((np.full_like(speed, 120.0 * KNOT), heading), 10, 10, fixture.Air(pressure=1.0, gust=0.1))
    with pytest.raises(NoAnswerError, match="--model bias"):
        calibrate(log)
    assert calibrate(log, CalibrationOptions(model="bias")).converged


def test_standing_still_is_bad_input():
    log = fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air())
    with pytest.raises(BadInputError, match="usable"):
        calibrate(replace(log, impact_pressure=np.full(len(log), 5.0)))


def test_stuck_gps_is_bad_input():
    log = fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air())
    stuck = np.full(len(log), 60.0)
    with pytest.raises(BadInputError, match="GPS"):
        calibrate(replace(log, velocity_north=stuck, velocity_east=stuck, gps_fresh=None))


def _in_knots_from_the_middle(log):
    factor = np.where(np.arange(len(log)) < len(log) // 2, 1.0, 1.0 / KNOT)
    return replace(log, velocity_north=factor * log.velocity_north, velocity_east=factor * log.velocity_east)


def _in_any_order(log):
    order = np.random.default_rng(1).permutation(len(log))
    channels = {f.name: getattr(log, f.name) for f in fields(log) if f.name != "time"}
    return replace(log, **{k: v[order] for k, v in channels.items() if isinstance(v, np.ndarray)})


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda log: replace(log, time=log.time / 3600.0), "unit of the time"),
        (lambda log: replace(log, time=log.time / 1000.0), "unit of the time"),
        (lambda log: replace(log, velocity_east=np.zeros(len(log))), "toward east is zero in every row"),
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
    speed, heading = np.repeat([160.0, 140.0, 120.0, 100.0], 120 * rate), np.linspace(0.0, 1440.0, 480 * rate)
    return speed * KNOT, np.deg2rad(heading)


def test_on_condition_needs_its_column():
    log = fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air())
    with pytest.raises(BadInputError, match="on_condition"):
        calibrate(log, CalibrationOptions(on_condition=True))


@pytest.mark.parametrize("choice", [{"method": "papre"}, {"error_location": "pitot"}])
def test_unknown_choices_name_the_known(choice):
    with pytest.raises(BadInputError, match="Known"):
        CalibrationOptions(**choice)


def test_unknown_model_names_the_nearest():
    with pytest.raises(UnknownNameError, match="'quadratic'"):
        CalibrationOptions(model="quadratc")


def test_missing_temperature_is_said():
    log = fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air())
    result = calibrate(replace(log, total_temperature=None))
    assert any("temperature" in warning for warning in result.warnings)


def test_knots_read_as_meters_per_second_get_no_answer():
    log = fixture.fly(fixture.circles(10), 10, 10, fixture.Air(gust=0.1))
    fast = replace(log, velocity_north=log.velocity_north / KNOT, velocity_east=log.velocity_east / KNOT)
    with pytest.raises(BadInputError, match=r"no airplane's is so large.*knots read as m/s"):
        calibrate(fast)


def test_a_curve_that_is_doubtfully_large_warns():
    log = fixture.fly(fixture.circles(10), 10, 10, fixture.Air(gust=0.1))
    assert not calibrate(log).warnings
    strong = replace(log, impact_pressure=0.85 * log.impact_pressure)
    assert any("a certified airplane's is smaller" in warning for warning in calibrate(strong).warnings)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda log: replace(log, velocity_east=np.minimum(log.velocity_east, 20.0)),
        lambda log: replace(log, velocity_east=log.velocity_east + np.where(log.time < 200.0, 0.0, 10.0)),
    ],
    ids=["clipped", "jumps by 10 m/s"],
)
def test_nobody_is_sent_to_fly_other_headings_where_all_were_flown(spoil):
    log = fixture.fly(fixture.circles(5), 5, 5, fixture.Air(gps=0.02, pressure=2.0), seed=7)
    with pytest.raises(NoAnswerError, match="air data and GPS velocity disagree") as found:
        calibrate(spoil(log))
    assert "fly" not in str(found.value)
