"""The evidence for further columns against dense normal densities."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from pitotbench.estimation.evidence import EvidencePart, column_evidence
from pitotbench.estimation.noise import Intervals, MarkovNoise, MarkovProcess

WIDE = 1e-4  # prior precision of the fitted coefficients


def problem(seed=1):
    """Two independent parts with gusts, three fitted coefficients and four further columns."""
    rng, parts = np.random.default_rng(seed), []
    for n in (40, 25):
        intervals = Intervals(np.arange(n + 1.0), np.arange(n))
        gusts = MarkovProcess(0.8, np.full(n + 1, 7.0), np.ones((n, 1)))
        noise = MarkovNoise(intervals, np.full(n, 0.3), [gusts])
        parts.append(EvidencePart(*(rng.standard_normal(shape) for shape in ((n,), (n, 3), (n, 4))), noise))
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
    assert found.log_bayes_factor(chosen, deviations) == pytest.approx(with_them - without, abs=1e-6)


def test_the_estimates_move_as_those_of_a_fit_with_the_further_columns_taken_off():
    parts, size = problem(), np.array([0.3, -1.0, 2.0, 0.5])
    found = column_evidence(parts, np.full(3, WIDE))

    def fitted(responses):
        normal = sum(part.regressors.T @ part.noise.weigh(part.regressors) for part in parts) + WIDE * np.eye(3)
        pull = sum(
            part.regressors.T @ part.noise.weigh(y[:, None])[:, 0] for part, y in zip(parts, responses, strict=True)
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
    assert np.mean(np.exp(found.log_bayes_factors(2.0 * found.drawn(20_000, 1), chosen, small))) > 1.2
