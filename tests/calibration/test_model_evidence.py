"""Evidence and mixture of hypotheses against the dense Gaussian formulas."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from pitotbench.calibration.average import moments, weigh_models
from pitotbench.calibration.model_evidence import Hypothesis
from pitotbench.estimation.noise import Intervals, MarkovNoise, MarkovProcess
from pitotbench.estimation.restricted_likelihood import Regression

N, WIDE = 20, 300.0
ZERO = np.zeros(3)


@pytest.fixture
def setup():
    rng = np.random.default_rng(8)
    t = np.linspace(-1.0, 1.0, N)
    X = np.column_stack([np.ones(N), t, np.sin(5.0 * t)])  # two of the curve, one that all share
    intervals = Intervals(np.arange(N + 1.0), np.arange(N))
    gust = MarkovProcess(0.5, np.full(N + 1, 4.0), np.ones((N, 1)))
    noises = [MarkovNoise(intervals, np.full(N, level), [gust]) for level in (0.2, 0.4)]
    y = X @ [0.3, 1.0, 2.0] + 0.6 * rng.standard_normal(N)
    thoughts = [
        Hypothesis("line", 0.0, 0.7, np.diag([1.0, 1.0])),
        Hypothesis("level", 0.0, 0.3, np.diag([1.0, 1e-4])),
    ]
    return Regression(y, X, X, np.zeros(X.shape[1])), noises, thoughts


def dense(problem, noise, thought):
    """Log-density of the response, and mean and covariance of θ, with a wide prior in place of a flat one.

    By one orthogonal factorization of the whitened regressors over the prior's: a difference of covariances,
    prior − gain X prior, would lose the wide prior's six digits, and which ones depends on the processor.
    """
    X = problem.regressors
    prior = np.diag([*np.diag(thought.covariance), WIDE**2])
    covariance = np.linalg.inv(noise.weigh(np.eye(N)))
    white = np.linalg.inv(np.linalg.cholesky(covariance))
    q, r = np.linalg.qr(np.concatenate([white @ X, np.diag(1.0 / np.sqrt(np.diag(prior)))]))
    root = np.linalg.inv(r)
    density = multivariate_normal.logpdf(problem.response, np.zeros(N), covariance + X @ prior @ X.T)
    return density, root @ (q[:N].T @ (white @ problem.response)), root @ root.T


def test_mixture_is_the_dense_one(setup):
    problem, noises, thoughts = setup
    masses = np.log([0.6, 0.4])
    answer, shares = weigh_models(
        thoughts, [moments(problem, ZERO, n, m) for n, m in zip(noises, masses, strict=True)]
    )
    cases = [(t, n, m) for t in thoughts for n, m in zip(noises, masses, strict=True)]
    found = [dense(problem, n, t) for t, n, _ in cases]
    logs = np.array([d + m + np.log(t.probability) for (d, _, _), (t, _, m) in zip(found, cases, strict=True)])
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    np.testing.assert_allclose(shares, weights.reshape(2, 2).sum(axis=1), rtol=1e-5)
    np.testing.assert_allclose(answer.mean, weights @ np.array([m for _, m, _ in found]), rtol=1e-5)
    assert len(answer.weights) == np.sum(weights > 1e-6)
    np.testing.assert_allclose(answer.covariances[0], found[0][2], rtol=1e-5, atol=1e-12)


def test_data_speak_for_the_true_law(setup):
    problem, noises, thoughts = setup
    _, shares = weigh_models(thoughts, [moments(problem, ZERO, noises[0], 0.0)])
    flat = replace(problem, response=problem.response - problem.regressors[:, 1])
    _, shares_flat = weigh_models(thoughts, [moments(flat, ZERO, noises[0], 0.0)])
    assert shares[0] > 0.7 > shares_flat[0]


def test_where_it_is_linearized_does_not_matter(setup):
    problem, noises, thoughts = setup
    theta = np.array([0.2, -0.4, 1.0])
    moved = replace(problem, response=problem.response - problem.regressors @ theta)
    here, there = (
        weigh_models(thoughts, [moments(p, t, noises[0], 0.0)]) for p, t in ((problem, ZERO), (moved, theta))
    )
    np.testing.assert_allclose(here[0].mean, there[0].mean, atol=1e-10)
    np.testing.assert_allclose(here[1], there[1], rtol=1e-8)
