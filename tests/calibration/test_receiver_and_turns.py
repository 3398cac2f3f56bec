"""What a receiver, a recorder and a turn do to a log: columns of the fit, each found again."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import lfilter
from scipy.stats import norm, truncnorm
from tests.calibration import trajectories as fixture

from pitotbench import CalibrationOptions, air
from pitotbench.calibration import calibrate
from pitotbench.calibration.observations import observe
from pitotbench.calibration.options import COLUMNS
from pitotbench.estimation.mixture import Posterior
from pitotbench.show.calibration import is_doubt
from pitotbench.units import KNOT

FREE = {"format": "pitotbench flight log 1", "accuracy": fixture.EXACT}
COMMAND = CalibrationOptions(model="smooth", latency="checked", error_location="static")
RATE = 4


def _circles_and_legs(bank: float = 30.0) -> tuple[np.ndarray, np.ndarray]:
    """A circle at a bank [degrees] and half a minute of straight flight at each of four speeds,
    with decelerations of 1 kt/s on straight legs between them.
    """
    speed, rate = [], []
    for first, last in ((160, 140), (140, 120), (120, 100), (100, 100)):
        turn = air.GRAVITY * np.tan(np.radians(bank)) / (first * KNOT * 1.1)
        rows = round(2.0 * np.pi / turn * RATE)
        straight = np.linspace(first, last, (abs(first - last) + 1) * RATE)
        speed += [np.full(rows, first), np.full(30 * RATE, first), straight]
        rate += [np.full(rows, turn), np.zeros(30 * RATE), np.zeros(len(straight))]
    return np.concatenate(speed) * KNOT, np.cumsum(np.concatenate(rate)) / RATE


def _flown(bank: float = 30.0):
    log = fixture.fly(_circles_and_legs(bank), RATE, RATE, fixture.Air())
    return replace(log, header=FREE)


def _inside(log, options=COMMAND, truth=fixture.TRUTH):
    found = calibrate(log, options)
    error = found.curve.correction - fixture.true_correction(found.curve.indicated_airspeed, truth)
    return found, float(np.mean(np.abs(error) < found.curve.two_sigma))


def _share(found, name):
    return next(each.estimate for each in found.shares if each.name == name)


def test_a_receiver_that_smooths_its_velocity_over_two_seconds_is_held():
    log = _flown()
    keep = np.exp(-1.0 / RATE / 2.0)
    slow = {
        name: lfilter([1.0 - keep], [1.0, -keep], v, zi=[keep * v[0]])[0]
        for name in ("velocity_north", "velocity_east")
        for v in [getattr(log, name)]
    }
    found, inside = _inside(replace(log, **slow))
    assert inside == 1.0
    squared = _share(found, "receiver_smoothing_s2")
    assert abs(squared.value - 4.0) < squared.two_sigma < 4.0
    # The trap: where the filter is said to be none, the curve is wrong.
    none = replace(COMMAND, priors={"receiver_smoothing_s2": 0.0})
    assert _inside(replace(log, **slow), none)[1] < 0.5


def test_rows_behind_the_last_fix_do_not_change_the_acceleration_before_it():
    """A velocity is held behind the last fix: a turn that goes on there does not end in the log."""
    path = _circles_and_legs()
    log = fixture.fly(tuple(each[: 100 * RATE + 3] for each in path), RATE, 1, fixture.Air())
    last = np.flatnonzero(log.gps_fresh)[-1]
    whole, cut = (observe(each, COMMAND) for each in (log, log.select(slice(0, last + 1))))
    assert len(log) > last + 1
    np.testing.assert_array_equal(whole.acceleration, cut.acceleration)


def test_a_recorder_that_stores_means_is_a_smoothing_over_a_twelfth_of_the_square_of_its_interval():
    log, rows = _flown(), 5 * RATE
    count = len(log) // rows * rows
    names = ("time", "impact_pressure", "static_pressure", "velocity_north", "velocity_east",
             "velocity_down", "total_temperature")  # fmt: skip
    means = {n: getattr(log, n)[:count].reshape(-1, rows).mean(axis=1) for n in names}
    stored = replace(log.select(np.arange(len(log)) % rows == 0), header=FREE)
    kept = {name: values[: len(stored)] for name, values in means.items()}
    stored = stored.select(np.arange(len(stored)) < count // rows)
    found, inside = _inside(replace(stored, **kept, gps_fresh=np.ones(len(stored), dtype=bool)))
    assert inside == 1.0
    squared = _share(found, "receiver_smoothing_s2")
    assert abs(squared.value - 25.0 / 12.0) < squared.two_sigma


def test_a_lift_part_that_grows_with_the_load_factor_is_found_from_the_turn_rate():
    """The static source has 4 % of the impact pressure times n q0/q: of level flight it is a curve,
    of a turn at 45° of bank the log shows the rest.
    """
    log = _flown(45.0)
    speed, heading = _circles_and_legs(45.0)
    still = air.true_airspeed(
        air.impact_pressure(speed), fixture.STATIC_PRESSURE, fixture.AIR_TEMPERATURE
    )
    load = np.hypot(1.0, still * np.gradient(heading) * RATE / air.GRAVITY)
    middle = 2500.0
    impact = log.impact_pressure - 0.04 * (load - 1.0) * middle
    found, inside = _inside(replace(log, impact_pressure=impact))
    assert inside == 1.0
    low, high = np.quantile(impact, [0.001, 0.999])
    lift = _share(found, "turn_lift")
    assert lift.value == pytest.approx(0.04 * middle / np.sqrt(low * high), rel=0.2)
    none = replace(COMMAND, priors={"turn_lift": 0.0, "receiver_smoothing_s2": 0.0})
    assert _inside(replace(log, impact_pressure=impact), none)[1] < 0.5


def test_a_good_flight_asks_for_no_column():
    found, inside = _inside(_flown())
    assert inside == 1.0
    assert not [each for each in found.warnings if each.code == "outside prior"]


@pytest.mark.parametrize("name", COLUMNS)
def test_a_column_of_width_zero_is_left_out_and_a_wider_one_widens_the_bound(name):
    log = replace(_flown(), altitude=np.full(len(_flown()), 1829.0))  # a height of no use
    widths = []
    for width in (0.0, 0.5, 4.0):
        stated = {name: width * (0.02 if name == "turn_lift" else 1.0)}
        found = calibrate(log, replace(COMMAND, priors=stated))
        assert (name in [each.name for each in found.shares]) == (width > 0.0)
        widths.append(float(np.mean(found.curve.two_sigma)))
    assert widths[0] < widths[2] or name == "height_latency_s"


def test_turns_to_one_side_are_told_with_what_sideslip_in_them_would_move():
    log = _flown()

    def told(found):
        return [each for each in found.warnings if each.code == "turns to one side"]

    speed, heading = _circles_and_legs()
    still = air.true_airspeed(
        air.impact_pressure(speed), fixture.STATIC_PRESSURE, fixture.AIR_TEMPERATURE
    )
    bank = np.abs(still * np.gradient(heading)) * RATE / air.GRAVITY  # its tangent
    slipped = log.impact_pressure * (1.0 - 0.01 * bank / np.tan(np.radians(30.0)))
    right = calibrate(log, COMMAND)
    wrong = calibrate(replace(log, impact_pressure=slipped), COMMAND)
    (caution,) = told(right)
    assert "all turns are to the right" in caution
    moved = np.max(np.abs(wrong.curve.correction - right.curve.correction))
    assert caution.moves.most == pytest.approx(moved, rel=0.3)
    # A note, since nothing contradicts the answer.
    assert not is_doubt(caution)
    half = len(heading) // 2
    both = np.r_[heading[:half], 2.0 * heading[half] - heading[half:]]
    mirrored = fixture.fly((speed, both), RATE, RATE, fixture.Air())
    assert not told(calibrate(replace(mirrored, header=FREE), COMMAND))


def test_a_probe_that_is_warm_when_slow_moves_the_curve_as_is_told():
    log = replace(_flown(), header={})
    slow = np.quantile(log.impact_pressure, 0.001)
    warmth = 5.0 * slow / np.maximum(log.impact_pressure, slow)
    right, wrong = (
        calibrate(each, COMMAND)
        for each in (log, replace(log, total_temperature=log.total_temperature + warmth))
    )
    moved = np.max(np.abs(wrong.curve.correction - right.curve.correction))
    assert right.day.by_slow_end == pytest.approx(moved, rel=0.15)


def test_the_answer_where_an_unknown_cannot_be_negative_has_the_moments_of_the_cut_gaussian():
    mean, covariance = np.array([-0.5, 1.0]), np.array([[1.0, 0.6], [0.6, 2.0]])
    wide = Posterior(np.array([1.0]), mean[None], covariance[None]).not_negative(0)
    cut = truncnorm(0.5, np.inf, loc=-0.5)
    assert wide.mean[0] == pytest.approx(cut.mean())
    assert wide.covariance[0, 0] == pytest.approx(cut.var())
    # The other unknown follows by its regression on the first.
    assert wide.mean[1] == pytest.approx(1.0 + 0.6 * (cut.mean() + 0.5))
    assert wide.covariance[1, 1] == pytest.approx(2.0 - 0.36 + 0.36 * cut.var())
    two = Posterior(np.array([0.5, 0.5]), np.array([[-3.0], [3.0]]), np.ones((2, 1, 1)))
    assert two.not_negative(0).weights[1] == pytest.approx(
        norm.cdf(3.0) / (norm.cdf(3.0) + norm.cdf(-3.0))
    )
    mass = quad(lambda x: norm.pdf(x, -3.0), 0.0, 20.0)[0]
    assert two.not_negative(0).weights[0] == pytest.approx(mass / (mass + norm.cdf(3.0)), rel=1e-6)


def test_an_answer_without_an_unknown_is_its_regression_at_zero():
    mean, covariance = np.array([0.5, 1.0]), np.array([[1.0, 0.6], [0.6, 2.0]])
    held = Posterior(np.array([1.0]), mean[None], covariance[None]).without(0)
    assert held.mean == pytest.approx([0.0, 1.0 - 0.6 * 0.5], abs=1e-5)
    assert held.covariance[1, 1] == pytest.approx(2.0 - 0.36, rel=1e-5)
    assert 0.0 < held.covariance[0, 0] < 1e-5
