"""What is taken for likely before a log is read, and evidence and mixture of hypotheses against
dense formulas.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal
from tests.calibration import trajectories as fixture

from pitotbench.calibration.average import moments, weigh_models
from pitotbench.calibration.covering import GUST_LENGTH, Structure, log_prior_of
from pitotbench.calibration.model_evidence import DEPARTURES, LEVEL, Hypothesis, hypotheses
from pitotbench.calibration.observations import observe
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.estimation.noise import Intervals, MarkovNoise, MarkovProcess
from pitotbench.estimation.restricted_likelihood import Regression
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE

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
    """Log-density of the response, and mean and covariance of θ, with a wide prior in place of a
    flat one.

    By one orthogonal factorization of the whitened regressors over the prior's: a difference of
    covariances, prior − gain X prior, would lose the wide prior's six digits, and which ones
    depends on the processor.
    """
    X = problem.regressors
    prior = np.diag([*np.diag(thought.covariance), WIDE**2])
    covariance = np.linalg.inv(noise.weigh(np.eye(N)))
    white = np.linalg.inv(np.linalg.cholesky(covariance))
    q, r = np.linalg.qr(np.concatenate([white @ X, np.diag(1.0 / np.sqrt(np.diag(prior)))]))
    root = np.linalg.inv(r)
    density = multivariate_normal.logpdf(
        problem.response, np.zeros(N), covariance + X @ prior @ X.T
    )
    return density, root @ (q[:N].T @ (white @ problem.response)), root @ root.T


def test_mixture_is_the_dense_one(setup):
    problem, noises, thoughts = setup
    masses = np.log([0.6, 0.4])
    answer, shares = weigh_models(
        thoughts, [moments(problem, ZERO, n, m) for n, m in zip(noises, masses, strict=True)]
    )
    cases = [(t, n, m) for t in thoughts for n, m in zip(noises, masses, strict=True)]
    found = [dense(problem, n, t) for t, n, _ in cases]
    logs = np.array(
        [d + m + np.log(t.probability) for (d, _, _), (t, _, m) in zip(found, cases, strict=True)]
    )
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
        weigh_models(thoughts, [moments(p, t, noises[0], 0.0)])
        for p, t in ((problem, ZERO), (moved, theta))
    )
    np.testing.assert_allclose(here[0].mean, there[0].mean, atol=1e-10)
    np.testing.assert_allclose(here[1], there[1], rtol=1e-8)


X = np.geomspace(1.0, 2.65, 61)
LAWS = [model for name, model in MODELS.items() if name != "spline"]


def covariance_of(name, size):
    return next(t.covariance for t in hypotheses(LAWS, X) if (t.name, t.departure) == (name, size))


@pytest.mark.parametrize("name", [law.name for law in LAWS])
def test_departure_has_its_size(name):
    """What two sizes differ by is departure alone; its mean square over ln x is the size's square."""
    small, large = (covariance_of(name, size) for size in DEPARTURES[:2])
    extra = np.trapezoid(np.diag(large - small), np.log(X)) / np.log(X[-1] / X[0])
    assert extra == pytest.approx(DEPARTURES[1] ** 2 - DEPARTURES[0] ** 2, rel=0.05)


def test_law_has_its_family_and_no_more():
    for law in LAWS:
        family = covariance_of(law.name, DEPARTURES[0]) - (
            covariance_of("bias", DEPARTURES[0]) - LEVEL**2 * np.ones((61, 61))
        )
        assert np.linalg.matrix_rank(family, tol=1e-9) == len(law.parameter_names)
        basis = law.basis(X)
        rest = family - basis @ np.linalg.lstsq(basis, family)[0]
        assert np.max(np.abs(rest)) < 1e-9


def test_probabilities_sum_to_one_half_are_lawless_and_the_scale_of_the_terms_does_not_matter():
    thoughts = hypotheses(LAWS, X)
    assert sum(t.probability for t in thoughts) == pytest.approx(1.0)
    assert sum(t.probability for t in thoughts if t.name == "spline") == pytest.approx(0.5)
    assert sum(t.probability for t in hypotheses([], X)) == pytest.approx(1.0)
    linear = MODELS["linear"]
    stretched = replace(
        linear, terms=(linear.terms[0], (lambda x: 1000.0 * x, lambda x: 1000.0 + 0.0 * x))
    )
    one, other = (
        np.stack([t.covariance for t in hypotheses([law], X)]) for law in (linear, stretched)
    )
    np.testing.assert_allclose(one, other, atol=1e-10)


STRUCTURE = Structure(PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE), (), drifting=False)


def log_prior_at(height_pressure):
    """The prior of a log at one static pressure."""
    log = fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air())
    log = replace(log, static_pressure=np.full(len(log), height_pressure))
    return log_prior_of(STRUCTURE, observe(log, CalibrationOptions()))


@pytest.mark.parametrize(
    ("height_pressure", "factor"), [(81200.0, 2.5), (69000.0, 4.0), (30000.0, 4.0)]
)
def test_a_length_one_factor_off_is_one_standard_deviation_off(height_pressure, factor):
    """2.5 low, 4 above 10,000 ft (69,682 Pa): gusts of 2,000 m are then nothing unusual."""
    log_prior = log_prior_at(height_pressure)
    usual = log_prior(np.log([0.5, GUST_LENGTH, 0.05]))
    for length in (GUST_LENGTH * factor, GUST_LENGTH / factor):
        assert log_prior(np.log([0.5, length, 0.05])) - usual == pytest.approx(-0.5, abs=1e-9)


@pytest.mark.parametrize("level", [1e-4, 1e-2])
def test_of_small_gusts_every_size_is_as_likely_as_the_next(level):
    """Jeffreys' prior: ten times less is no less likely, so that calm air may be found calm."""
    log_prior = log_prior_at(81200.0)
    more, less = (log_prior(np.log([size, GUST_LENGTH, 0.05])) for size in (level, 0.1 * level))
    assert more == pytest.approx(less, abs=1e-4)
