"""The banded covariance against the dense one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pitotbench.estimate.markov_noise import MarkovNoise, MarkovProcess


def dense(time, white, processes):
    lag = np.abs(time[:, None] - time[None, :])
    total = np.diag(white)
    for p in processes:
        total = total + p.deviation**2 * np.outer(p.loading, p.loading) * np.exp(-lag / p.correlation_time[0])
    return total


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    count=st.integers(0, 3),
    deviation=st.floats(1e-3, 5.0),
    scale=st.floats(0.5, 500.0),
)
def test_products_and_determinant_match_the_dense_covariance(seed, count, deviation, scale):
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.2, 3.0, 25))
    white = rng.uniform(0.01, 0.3, 25)
    processes = [
        MarkovProcess(deviation * (j + 1), np.full(25, scale * 3.0**j), rng.uniform(-1, 1, 25))
        for j in range(count)
    ]
    noise, covariance = MarkovNoise(time, white, processes), dense(time, white, processes)
    data = rng.standard_normal((25, 4))
    np.testing.assert_allclose(noise.weigh(data), np.linalg.solve(covariance, data), rtol=1e-6, atol=1e-7)
    assert noise.log_determinant == pytest.approx(np.linalg.slogdet(covariance)[1], abs=1e-6)


def test_a_long_gap_makes_parts_independent():
    time = np.array([0.0, 1.0, 1e6, 1e6 + 1.0])
    process = MarkovProcess(1.0, np.full(4, 10.0), np.ones(4))
    unit = np.zeros((4, 1))
    unit[0] = 1.0
    weighed = MarkovNoise(time, np.full(4, 0.1), [process]).weigh(unit)
    np.testing.assert_allclose(weighed[2:], 0.0, atol=1e-12)
