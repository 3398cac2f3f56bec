"""Held-out densities against leaving the data out in earnest, likelihoods against the dense form."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from pitotbench.estimation.evidence import aicc, bic, held_out_log_density, log_likelihood
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
    noise = MarkovNoise(INTERVALS, np.full(N, 0.3), [MarkovProcess(0.8, np.full(N + 1, 6.0), loading)])
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
        assert score == pytest.approx(multivariate_normal.logpdf(problem.response[out], mean, spread), abs=1e-8)


def test_without_a_prior_it_is_the_limit_of_a_wide_one(setup):
    problem, noise, _ = setup
    flat = held_out_log_density(problem, noise, np.zeros((2, 2)), SEGMENT)
    wide = held_out_log_density(problem, noise, 1e-9 * np.eye(2), SEGMENT)
    np.testing.assert_allclose(flat, wide, atol=1e-6)


def test_a_wrong_model_predicts_worse(setup):
    problem, noise, _ = setup
    level = Regression(problem.response, problem.regressors[:, :1], problem.instruments[:, :1], np.zeros(1))
    steep = replace(level, response=problem.response + 20.0 * problem.regressors[:, 1])
    assert held_out_log_density(steep, noise, np.zeros((1, 1)), SEGMENT).sum() < -50.0
    assert held_out_log_density(problem, noise, np.zeros((2, 2)), SEGMENT).sum() > -50.0


def test_likelihood_is_the_dense_one(setup):
    problem, noise, covariance = setup
    weight = np.linalg.inv(covariance)
    X = problem.regressors
    best = X @ np.linalg.solve(X.T @ weight @ X, X.T @ weight @ problem.response)
    assert log_likelihood(problem, noise) == pytest.approx(
        multivariate_normal.logpdf(problem.response, best, covariance)
    )


def test_criteria_of_the_source():
    """Burnham and Anderson, Model Selection, 2002, eqs. 2.15 and 6.6: -2 ln L + 2K + 2K(K+1)/(n-K-1), K ln n."""
    assert aicc(-10.0, 3, 20) == pytest.approx(20.0 + 6.0 + 24.0 / 16.0)
    assert bic(-10.0, 3, 20) == pytest.approx(20.0 + 3.0 * np.log(20.0))
