"""The noise of fixed-speed points, held against dense linear algebra that knows nothing of groups
or recursions.
"""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture
from tests.calibration.test_fixed_speed_points import RATE, circle_path, legs_path
from threadpoolctl import threadpool_info, threadpool_limits

from pitotbench.calibration import leg_points
from pitotbench.calibration.covering_problem import wind_log_prior
from pitotbench.calibration.leg_methods import (
    answer_of_legs,
    circle_fit,
    circle_gain,
    solve_group,
)
from pitotbench.calibration.leg_points import (
    answer_variances,
    noise_of,
    regression_of,
    steady_groups,
    two_sigma,
)
from pitotbench.calibration.observations import observe
from pitotbench.calibration.options import PRIORS, CalibrationOptions
from pitotbench.estimation.mixture import half_width
from pitotbench.estimation.restricted_likelihood import (
    Regression,
    restricted_log_likelihood,
    weighted_noises,
)

NOISES = np.log([[0.8, 533.0, 0.2], [0.1, 200.0, 0.4], [2.0, 1500.0, 0.05]])


def groups_of(path, seed=1):
    log = fixture.fly(path, RATE, RATE, fixture.Air(), seed)
    return [solve_group(group) for group in steady_groups(log, observe(log, CalibrationOptions()))]


def dense_covariance(groups, noise):
    """Of the means over all pairs of seconds, by the double integral of exp(−|t − s|/τ) in closed
    form; the airspeed, which changes a little from group to group, is the mean of the pair's."""
    deviation, length, white = np.exp(noise)
    time = np.concatenate([group.group.time for group in groups])
    along = np.concatenate([group.along for group in groups])
    airspeed = np.concatenate([np.full(len(group.along), group.answer[0]) for group in groups])
    a = 0.5 * (airspeed[:, None] + airspeed) / length
    apart = np.abs(time[:, None] - time)
    mean = np.where(
        apart < 0.5,
        2.0 * (a - 1.0 + np.exp(-a)) / a**2,
        (np.exp(-a * (apart - 1.0)) - 2.0 * np.exp(-a * apart) + np.exp(-a * (apart + 1.0))) / a**2,
    )
    return deviation**2 * mean * (along @ along.T) + (white**2 + 1e-8) * np.eye(len(time))


class DenseNoise:
    """What an estimator asks of a covariance, by explicit matrices."""

    def __init__(self, covariance):
        self.log_determinant = np.linalg.slogdet(covariance)[1]
        self.inverse = np.linalg.inv(covariance)

    def weigh(self, data):
        return self.inverse @ data


def dense_problem(groups):
    """An airspeed and a wind for each group; the response and the regressors."""
    lengths = [len(group.along) for group in groups]
    regressors = np.zeros((sum(lengths), 3 * len(groups)))
    for number, (group, first) in enumerate(zip(groups, np.cumsum([0, *lengths]), strict=False)):
        columns = np.column_stack([np.ones(len(group.along)), group.along])
        regressors[first : first + len(group.along), 3 * number : 3 * number + 3] = columns
    return np.concatenate([group.residual for group in groups]), regressors


def dense_likelihood(groups, covariance):
    """Harville (1974), by explicit inverses."""
    residual, regressors = dense_problem(groups)
    inverse = np.linalg.inv(covariance)
    normal = regressors.T @ inverse @ regressors
    estimate = np.linalg.solve(normal, regressors.T @ inverse @ residual)
    rest = residual - regressors @ estimate
    return -0.5 * (
        np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(normal)[1] + rest @ inverse @ rest
    )


@pytest.mark.parametrize("path", [legs_path(0, 90, 180, 270), circle_path()])
def test_the_likelihood_of_a_group_is_that_of_dense_generalized_least_squares(path):
    groups = groups_of(path)
    for noise in NOISES:
        for one in groups:
            dense = dense_likelihood([one], dense_covariance([one], noise))
            found = restricted_log_likelihood(regression_of(one), noise_of(one)(noise))
            assert found == pytest.approx(dense, rel=1e-7, abs=1e-5)


@pytest.mark.parametrize(
    "path", [legs_path(0, 90, 180, 270), legs_path(0, 72, 144, 216, 288), circle_path()]
)
def test_the_variance_of_an_answer_is_that_of_the_full_covariance(path):
    for group in groups_of(path):
        dense = [
            np.diag(group.gain.T @ dense_covariance([group], noise) @ group.gain)
            for noise in NOISES
        ]
        np.testing.assert_allclose(answer_variances(group, NOISES), dense, rtol=1e-5)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_gusts_that_two_groups_share_move_no_bound_by_a_percent(seed):
    """The bound with every correlation, also from group to group, by dense matrices."""
    groups = groups_of(legs_path(0, 90, 180, 270, speeds_kt=(110.0, 125.0, 140.0)), seed)

    response, regressors = dense_problem(groups)
    level = response.std()
    noises, weights = weighted_noises(
        [
            (
                Regression(response, regressors, regressors, np.zeros(regressors.shape[1])),
                lambda noise: DenseNoise(dense_covariance(groups, noise)),
            )
        ],
        wind_log_prior(PRIORS, PRIORS.gust_length_factor),
        np.log([level, PRIORS.gust_length_m, 0.3 * level]),  # where both searches begin
    )
    for group, bound in zip(groups, two_sigma(groups), strict=True):
        variances = [
            np.diag(group.gain.T @ dense_covariance([group], noise) @ group.gain)
            for noise in noises
        ]
        expected = half_width(weights, np.zeros((len(weights), 3)), np.sqrt(variances))
        np.testing.assert_allclose(bound, expected, rtol=0.01)


def at(one, time, gain=1.0):
    """A group whose rows are repeated, at other times [s], with another gain."""
    rows = np.arange(len(time)) % len(one.along)
    return replace(
        one,
        group=replace(one.group, time=time),
        along=one.along[rows],
        residual=one.residual[rows],
        gain=gain * one.gain[rows],
    )


def test_the_seconds_of_a_group_are_in_order():
    """Legs are joined by track; the noise goes by time."""
    for group in groups_of(legs_path(0, 90, 180, 270)):
        assert np.all(np.diff(group.group.time) > 0.0)


@pytest.mark.parametrize(
    "path",
    [
        legs_path(0, 90, 180, 270),
        legs_path(0, 120, 240),
        legs_path(0, 72, 144, 216, 288),
        circle_path(),
    ],
)
def test_the_gain_is_what_a_second_moved_along_its_path_does_to_the_answer(path):
    for one in groups_of(path):
        along, gain = one.along, one.gain
        for second in range(0, len(along), 7):
            step = 1e-3 * (np.arange(len(along)) == second)[:, None] * along
            moved = (one.velocity + sign * step for sign in (1, -1))
            ahead, behind = (
                circle_fit(each)
                if one.group.turning
                else answer_of_legs(one.group.leg_means(each))[0]
                for each in moved
            )
            np.testing.assert_allclose(gain[second], (ahead - behind) / 2e-3, rtol=1e-4, atol=1e-7)


def test_the_gain_of_a_circle_counts_that_the_path_turns_when_the_wind_moves():
    """Far from a circle the residuals are large: without their curvature the gain would be off by a
    fifth.
    """

    def settled(velocity, answer):
        """By sixty Gauss-Newton steps: the usual six do not settle on such an oval."""
        for _ in range(60):
            through_air = velocity - answer[1:]
            distance = np.linalg.norm(through_air, axis=1)
            jacobian = np.column_stack([np.ones(len(velocity)), through_air / distance[:, None]])
            answer = answer + np.linalg.lstsq(jacobian, distance - answer[0])[0]
        return answer

    velocity = 60.0 * np.array([(np.cos(x), 0.6 * np.sin(x)) for x in np.arange(0.0, 5.0, 0.2)])
    answer = settled(velocity, circle_fit(velocity))
    through_air = velocity - answer[1:]
    along = through_air / np.linalg.norm(through_air, axis=1, keepdims=True)
    gain = circle_gain(velocity, answer)
    for second in (0, 9, 20):
        moved = velocity + 1e-3 * (np.arange(len(velocity)) == second)[:, None] * along
        there = settled(moved, answer)
        np.testing.assert_allclose(gain[second], (there - answer) / 1e-3, rtol=1e-2, atol=1e-4)


def peak_memory(groups):
    tracemalloc.start()
    two_sigma(groups)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def test_memory_grows_with_the_number_of_groups_and_not_with_its_square():
    """Copies of one turn, an hour apart."""
    (one,) = groups_of(circle_path())
    copies = [at(one, one.group.time + 3600.0 * hour) for hour in range(40)]
    assert peak_memory(copies) <= 5.0 * peak_memory(copies[:10])


def test_a_long_turn_needs_no_matrix_of_all_its_pairs_of_seconds():
    """Two hours of circling in gusts: 7,200² numbers are 415 MB."""
    (one,) = groups_of(circle_path())
    assert peak_memory([at(one, np.arange(7200.0), len(one.along) / 7200.0)]) < 40e6


def test_points_are_found_on_one_thread(monkeypatch):
    threads = []

    def watched(*arguments):
        threads.extend(library["num_threads"] for library in threadpool_info())
        return steady_groups(*arguments)

    monkeypatch.setattr(leg_points, "steady_groups", watched)
    log = fixture.fly(circle_path(), RATE, RATE, fixture.CALM)
    with threadpool_limits(limits=2):
        assert leg_points.fixed_speed_points(log)
    assert set(threads) == {1}
