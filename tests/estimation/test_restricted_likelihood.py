"""Restricted likelihood against its dense textbook form; the mixture and its design against
identities.
"""

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import norm

from pitotbench.estimation.mixture import TWO_SIGMA_SHARE, half_width
from pitotbench.estimation.noise import Intervals, MarkovNoise
from pitotbench.estimation.restricted_likelihood import (
    Regression,
    composite_design,
    noise_posterior,
    restricted_log_likelihood,
    solutions,
    solve,
)
from pitotbench.records import NoAnswerError


def make_problem(n=60, seed=3):
    rng = np.random.default_rng(seed)
    X = np.column_stack([np.ones(n), np.linspace(-1, 1, n)])
    response = X @ [1.0, 2.0] + rng.standard_normal(n)
    return Regression(response, X, X, np.zeros(2)), Intervals(np.arange(n + 1.0), np.arange(n))


class White:
    """White noise of one variance."""

    def __init__(self, count, variance):
        self.log_determinant, self._variance = count * np.log(variance), variance

    def weigh(self, data):
        return data / self._variance


def level(intervals):
    """White noise of an unknown level, by its logarithm."""
    return lambda phi: MarkovNoise(intervals, np.full(len(intervals.left), np.exp(2 * phi[0])), [])


def test_restricted_likelihood_matches_the_dense_form():
    problem, intervals = make_problem()
    n = len(intervals.left)
    white = np.linspace(0.5, 1.5, n)
    C = np.diag(white)
    X, y, weight = problem.regressors, problem.response, np.linalg.inv(C)
    normal = X.T @ weight @ X
    beta = np.linalg.solve(normal, X.T @ weight @ y)
    rest = y - X @ beta
    wanted = -0.5 * (np.linalg.slogdet(C)[1] + np.linalg.slogdet(normal)[1] + rest @ weight @ rest)
    noise = MarkovNoise(intervals, white, [])
    assert restricted_log_likelihood(problem, noise) == pytest.approx(wanted, abs=1e-8)
    estimate, covariance = solve(problem, noise)
    np.testing.assert_allclose(estimate, beta, rtol=1e-9)
    np.testing.assert_allclose(covariance, np.linalg.inv(normal), rtol=1e-8, atol=1e-12)


def test_the_likelihood_takes_the_instruments_for_regressors():
    """Measurement noise of a regressor is in the response as well, and must not pass for something
    explained.
    """
    problem, intervals = make_problem()
    noisy = problem.regressors + 0.1 * np.random.default_rng(4).standard_normal(
        problem.regressors.shape
    )
    measured = Regression(problem.response, noisy, problem.instruments, problem.prior_precision)
    noise = MarkovNoise(intervals, np.ones(60), [])
    assert restricted_log_likelihood(measured, noise) == restricted_log_likelihood(problem, noise)


def test_regressors_that_are_one_and_the_same_get_a_reason_and_no_answer():
    problem, intervals = make_problem()
    twice = np.column_stack([problem.regressors, problem.regressors])
    same = Regression(problem.response, twice, twice, np.zeros(4))
    with pytest.raises(NoAnswerError, match="does not determine"):
        noise_posterior(same, level(intervals), lambda phi: -0.5 * float(phi @ phi), np.zeros(1))


def test_white_noise_posterior_gives_student_like_bounds():
    """With one unknown white level the mixture must be wider than the plug-in normal, as Student's
    t is.
    """
    problem, intervals = make_problem(n=12)
    nodes = noise_posterior(problem, level(intervals), lambda phi: 0.0, np.zeros(1))
    weights = np.array([node.weight for node in nodes])
    means = np.array([node.estimate[1:] for node in nodes])
    deviations = np.sqrt([[node.covariance[1, 1]] for node in nodes])
    rest = (
        problem.response
        - problem.regressors @ np.linalg.lstsq(problem.regressors, problem.response)[0]
    )
    plug_in = np.sqrt(
        rest @ rest / 10 * np.linalg.inv(problem.regressors.T @ problem.regressors)[1, 1]
    )
    student = 2.28  # 95.45 % two-sided quantile, 10 degrees of freedom
    assert half_width(weights, means, deviations)[0] == pytest.approx(student * plug_in, rel=0.08)


@pytest.mark.parametrize("dimensions", [1, 2, 3, 4, 6, 7, 8])
def test_design_has_the_moments_of_a_gaussian(dimensions):
    """Also one of few corners, which many dimensions get."""
    design = composite_design(dimensions)
    weights = design.weights * np.exp(-0.5 * np.sum(design.points**2, axis=1))
    assert dimensions < 6 or len(weights) == 1 + 2 * dimensions + 16
    assert weights.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(weights @ design.points, 0.0, atol=1e-12)
    second = (design.points.T * weights) @ design.points
    np.testing.assert_allclose(second, np.eye(dimensions), atol=1e-9 if dimensions < 6 else 1e-12)


def test_half_width_of_a_mixture_holds_its_share():
    weights, means, deviations = (
        np.array([0.3, 0.7]),
        np.array([[0.0], [1.0]]),
        np.array([[1.0], [0.5]]),
    )
    h, center = half_width(weights, means, deviations)[0], 0.7
    inside = sum(
        w * (norm.cdf(center + h, m, s) - norm.cdf(center - h, m, s))
        for w, m, s in zip(weights, means[:, 0], deviations[:, 0], strict=True)
    )
    assert inside == pytest.approx(TWO_SIGMA_SHARE, abs=1e-6)
    # Of one Gaussian it is two σ.
    assert half_width(np.ones(1), np.array([[3.0]]), np.array([[0.7]]))[0] == pytest.approx(
        1.4, rel=1e-6
    )


def test_rival_priors_are_weighed_as_dense_algebra_weighs_them():
    """y ~ N(Xm, C + XSXᵀ) under a prior N(m, S), with a flat prior of the first coefficient."""
    rng = np.random.default_rng(5)
    X = np.column_stack([np.ones(40), rng.standard_normal((40, 2))])
    y = X @ np.array([1.0, 0.3, -0.2]) + 0.5 * rng.standard_normal(40)
    mean = np.array([0.0, 0.1, -0.1])
    precisions = np.array([[0.0, 4.0, 9.0], [0.0, 100.0, 400.0]])
    white = White(40, 0.25)
    problem = Regression(y, X, X, precisions, mean)
    found = [
        restricted_log_likelihood(Regression(y, X, X, each[None], mean), white)
        for each in precisions
    ]
    dense = []
    for each in precisions:
        spread = 0.25 * np.eye(40) + (X[:, 1:] / each[1:]) @ X[:, 1:].T
        rest, one = y - X[:, 1:] @ mean[1:], np.ones((40, 1))
        weighed = np.linalg.solve(spread, np.column_stack([one, rest]))
        inner = float((one.T @ weighed[:, :1])[0, 0])
        left = float(rest @ weighed[:, 1]) - float(one[:, 0] @ weighed[:, 1]) ** 2 / inner
        dense.append(-0.5 * (np.linalg.slogdet(spread)[1] + np.log(inner) + left))
    known = 0.5 * np.sum(np.log(precisions[:, 1:]), axis=1)  # left out of a single prior
    assert found[1] + known[1] - found[0] - known[0] == pytest.approx(dense[1] - dense[0], abs=1e-8)
    both = restricted_log_likelihood(problem, white)
    assert both == pytest.approx(np.logaddexp(*(np.array(found) + known)) - np.log(2.0), abs=1e-8)
    weights = [each.weight for each in solutions(problem, white)]
    np.testing.assert_allclose(weights, np.exp(dense - logsumexp(dense)), atol=1e-9)


def test_a_prior_draws_the_answer_to_its_mean():
    X = np.eye(2)
    found, covariance = solve(
        Regression(np.array([1.0, 1.0]), X, X, np.array([3.0, 0.0]), np.array([-1.0, 5.0])),
        White(2, 1.0),
    )
    np.testing.assert_allclose(found, [(1.0 - 3.0) / 4.0, 1.0])
    np.testing.assert_allclose(np.diag(covariance), [0.25, 1.0])
