"""The ideal observer against brute force, on a linear Gaussian toy."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from pitotlab.blind.observer import (
    NONE,
    PRIOR,
    STRONGEST,
    WEAKEST,
    log_evidence,
    probabilities,
    without_free,
)


def toy(seed: int, samples: int = 14, causes: int = 3):
    draw = np.random.default_rng(seed)
    free, deviations = draw.standard_normal((samples, 2)), np.array([3.0, 0.7])
    return draw, free, deviations, 2.0 * draw.standard_normal((samples, causes))


def filtered(signatures, residual, free, deviations):
    inner = without_free(np.column_stack([signatures, residual]), free, deviations)
    return inner[:-1, -1] / np.sqrt(np.diag(inner)[:-1]), np.sqrt(np.diag(inner)[:-1])


def test_the_evidence_is_that_of_an_integral_over_sizes_and_free_parameters() -> None:
    draw, free, deviations, signatures = toy(1)
    covariance = np.eye(14) + free @ np.diag(deviations**2) @ free.T
    residual = draw.multivariate_normal(4.0 * signatures[:, 1], covariance)
    found, strength = filtered(signatures, residual, free, deviations)
    base = multivariate_normal(np.zeros(14), covariance).logpdf(residual)
    # Sizes whose strengths are log-uniform, by the trapezoidal rule on a grid of its own.
    x = np.geomspace(WEAKEST, STRONGEST, 9001)
    for column, (value, unit) in enumerate(zip(found, strength, strict=True)):
        plus = x[:, None] / unit * signatures[:, column]
        left = residual[None, :] - np.concatenate([plus, -plus])
        scores = multivariate_normal(np.zeros(14), covariance).logpdf(left)
        likelihood = np.exp(scores - base).reshape(2, -1)
        mean = np.trapezoid(likelihood.mean(axis=0), np.log(x)) / np.log(STRONGEST / WEAKEST)
        assert log_evidence(np.array([value]))[0] == pytest.approx(float(np.log(mean)), abs=0.01)


def test_a_free_parameter_of_no_prior_takes_its_direction_out() -> None:
    _, free, _, signatures = toy(2)
    columns = np.column_stack([signatures, free @ [2.0, -5.0]])
    inner = without_free(columns, free, np.array([1e6, 1e6]))
    assert inner[-1] == pytest.approx(np.zeros(4), abs=1e-6)


def test_its_probabilities_are_right_as_often_as_they_say() -> None:
    """Cases from the prior: the mean probability of being a cause is the share of it."""
    draw, free, deviations, signatures = toy(3)
    names = ["pitot_lag", "belly_pod", "loose_tube"]
    outside, inside = PRIOR["outside"], PRIOR["table"] / 2.0
    covariance = np.linalg.cholesky(np.eye(14) + free @ np.diag(deviations**2) @ free.T)
    _, strength = filtered(signatures, np.zeros(14), free, deviations)
    given, right = [], []
    for _ in range(500):
        truth = str(draw.choice([*names, NONE], p=[inside, inside, outside, PRIOR[NONE]]))
        residual = covariance @ draw.standard_normal(14)
        if truth != NONE:
            i = names.index(truth)
            size = np.exp(draw.uniform(np.log(WEAKEST), np.log(STRONGEST)))
            x = float(size) * draw.choice([-1.0, 1.0])
            residual = residual + x / strength[i] * signatures[:, i]
        values = log_evidence(filtered(signatures, residual, free, deviations)[0])
        told = probabilities({n: [float(v)] for n, v in zip(names, values, strict=True)})
        assert sum(told.values()) == pytest.approx(1.0)
        given += list(told.values())
        right += [cause == truth for cause in told]
    for low, high in ((0.0, 0.2), (0.2, 0.8), (0.8, 1.01)):
        inside_it = [(p, r) for p, r in zip(given, right, strict=True) if low <= p < high]
        p, share = np.mean(np.array(inside_it, dtype=float), axis=0)
        assert abs(p - share) < 4.0 * np.sqrt(max(p * (1.0 - p), 1e-3) / len(inside_it))
