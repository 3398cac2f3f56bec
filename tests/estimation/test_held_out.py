"""Held-out densities against leaving the data out in earnest, likelihoods against the dense form."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from pitotbench.estimation.evidence import (
    EvidencePart,
    aicc,
    bic,
    column_evidence,
    held_out_log_density,
    log_likelihood,
)
from pitotbench.estimation.noise import Intervals, MarkovNoise, MarkovProcess
from pitotbench.estimation.restricted_likelihood import Regression

N = 24
INTERVALS = Intervals(np.arange(N + 1.0), np.arange(N))
SEGMENT = np.arange(N) // 8


@pytest.fixture
def setup():
    rng = np.random.default_rng(5)
    X = np.column_stack([np.ones(N), np.linspace(-1.0, 1.0, N)])
    loading = np.ones((N, 1))
    noise = MarkovNoise(
        INTERVALS, np.full(N, 0.3), [MarkovProcess(0.8, np.full(N + 1, 6.0), loading)]
    )
    covariance = np.linalg.inv(noise.weigh(np.eye(N)))
    y = X @ [0.5, -1.0] + np.linalg.cholesky(covariance) @ rng.standard_normal(N)
    return Regression(y, X, X, np.zeros(X.shape[1])), noise, covariance


def test_density_is_that_of_leaving_out(setup):
    """Coefficients with a proper prior: condition the joint Gaussian of all data on the kept ones."""
    problem, noise, covariance = setup
    prior = np.diag([2.0, 0.5])
    joint = covariance + problem.regressors @ np.linalg.inv(prior) @ problem.regressors.T
    found = held_out_log_density(problem, noise, prior, SEGMENT)
    for number, score in enumerate(found):
        out = np.isin(SEGMENT, number)
        kept = ~out
        gain = joint[np.ix_(out, kept)] @ np.linalg.inv(joint[np.ix_(kept, kept)])
        mean = gain @ problem.response[kept]
        spread = joint[np.ix_(out, out)] - gain @ joint[np.ix_(kept, out)]
        assert score == pytest.approx(
            multivariate_normal.logpdf(problem.response[out], mean, spread), abs=1e-8
        )
    # Without a prior it is the limit of a wide one.
    flat, wide = (
        held_out_log_density(problem, noise, each * np.eye(2), SEGMENT) for each in (0.0, 1e-9)
    )
    np.testing.assert_allclose(flat, wide, atol=1e-6)


def test_a_wrong_model_predicts_worse(setup):
    problem, noise, _ = setup
    level = Regression(
        problem.response, problem.regressors[:, :1], problem.instruments[:, :1], np.zeros(1)
    )
    steep = replace(level, response=problem.response + 20.0 * problem.regressors[:, 1])
    assert held_out_log_density(steep, noise, np.zeros((1, 1)), SEGMENT).sum() < -50.0
    assert held_out_log_density(problem, noise, np.zeros((2, 2)), SEGMENT).sum() > -50.0


def test_likelihood_is_the_dense_one_and_the_criteria_are_those_of_the_source(setup):
    """Burnham and Anderson, Model Selection, 2002, eqs. 2.15 and 6.6: -2 ln L + 2K +
    2K(K+1)/(n-K-1), K ln n.
    """
    problem, noise, covariance = setup
    X, weight = problem.regressors, np.linalg.inv(covariance)
    best = X @ np.linalg.solve(X.T @ weight @ X, X.T @ weight @ problem.response)
    dense = multivariate_normal.logpdf(problem.response, best, covariance)
    assert log_likelihood(problem, noise) == pytest.approx(dense)
    assert aicc(-10.0, 3, 20) == pytest.approx(20.0 + 6.0 + 24.0 / 16.0)
    assert bic(-10.0, 3, 20) == pytest.approx(20.0 + 3.0 * np.log(20.0))


WIDE = 1e-4  # prior precision of the fitted coefficients


def problem(seed=1):
    """Two independent parts with gusts, three fitted coefficients and four further columns."""
    rng, parts = np.random.default_rng(seed), []
    for n in (40, 25):
        intervals = Intervals(np.arange(n + 1.0), np.arange(n))
        gusts = MarkovProcess(0.8, np.full(n + 1, 7.0), np.ones((n, 1)))
        noise = MarkovNoise(intervals, np.full(n, 0.3), [gusts])
        parts.append(
            EvidencePart(*(rng.standard_normal(shape) for shape in ((n,), (n, 3), (n, 4))), noise)
        )
    return parts


def covariance_of(parts, deviations):
    """The dense covariance of all rows, with the coefficients integrated out."""
    total = sum(len(part.response) for part in parts)
    dense, place = np.zeros((total, total)), 0
    for part in parts:
        n = len(part.response)
        dense[place : place + n, place : place + n] = np.linalg.inv(part.noise.weigh(np.eye(n)))
        place += n
    fitted = np.concatenate([part.regressors for part in parts])
    further = np.concatenate([part.further for part in parts])[:, : len(deviations)]
    return dense + fitted @ fitted.T / WIDE + (further * deviations**2) @ further.T


@pytest.mark.parametrize("deviations", [(0.5, 2.0), (1e-3, 1e-3), (3.0, 3.0, 0.1, 1.0)])
def test_the_bayes_factor_is_the_ratio_of_two_normal_densities(deviations):
    parts, deviations = problem(), np.array(deviations)
    found = column_evidence(parts, np.full(3, WIDE))
    response = np.concatenate([part.response for part in parts])
    zero = np.zeros(len(response))
    with_them = multivariate_normal.logpdf(response, zero, covariance_of(parts, deviations))
    without = multivariate_normal.logpdf(response, zero, covariance_of(parts, np.zeros(0)))
    chosen = np.arange(len(deviations))
    assert found.log_bayes_factor(chosen, deviations) == pytest.approx(
        with_them - without, abs=1e-6
    )


def test_the_estimates_move_as_those_of_a_fit_with_the_further_columns_taken_off():
    parts, size = problem(), np.array([0.3, -1.0, 2.0, 0.5])
    found = column_evidence(parts, np.full(3, WIDE))

    def fitted(responses):
        normal = sum(
            part.regressors.T @ part.noise.weigh(part.regressors) for part in parts
        ) + WIDE * np.eye(3)
        pull = sum(
            part.regressors.T @ part.noise.weigh(y[:, None])[:, 0]
            for part, y in zip(parts, responses, strict=True)
        )
        return np.linalg.solve(normal, pull)

    before = fitted([part.response for part in parts])
    after = fitted([part.response - part.further @ size for part in parts])
    np.testing.assert_allclose(found.moved @ size, after - before, rtol=1e-8)


def test_without_the_columns_the_bayes_factor_is_one_in_the_mean():
    """An identity of any Bayes factor. Two columns that are equal do not disturb it."""
    parts = problem()
    for part in parts:
        part.further[:, 3] = part.further[:, 2]
    found, chosen = column_evidence(parts, np.full(3, WIDE)), np.arange(4)
    small = 0.5 / np.sqrt(np.diag(found.precision))
    factors = np.exp(found.log_bayes_factors(found.drawn(20_000, 1), chosen, small))
    assert np.mean(factors) == pytest.approx(1.0, abs=4.0 * np.std(factors) / np.sqrt(len(factors)))
    assert (
        np.mean(np.exp(found.log_bayes_factors(2.0 * found.drawn(20_000, 1), chosen, small))) > 1.2
    )
