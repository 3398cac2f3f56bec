"""A noise with added columns against the dense covariance."""

import numpy as np

from pitotbench.estimate.added_columns import AddedColumns
from pitotbench.estimate.markov_noise import Intervals, MarkovNoise, MarkovProcess


def test_products_and_determinant_are_those_of_the_sum_of_covariances():
    rng, n = np.random.default_rng(5), 40
    intervals = Intervals(np.arange(n + 1.0), np.arange(n))
    gusts = MarkovNoise(intervals, np.full(n, 0.3), [MarkovProcess(0.8, np.full(n + 1, 7.0), np.ones((n, 1)))])
    columns = rng.standard_normal((n, 2))
    alone = np.linalg.inv(gusts.weigh(np.eye(n)))
    whole = alone + 3.0**2 * columns @ columns.T
    found = AddedColumns(gusts, columns, 3.0)
    np.testing.assert_allclose(found.weigh(np.eye(n)), np.linalg.inv(whole), atol=1e-9)
    added = np.linalg.slogdet(whole)[1] - np.linalg.slogdet(alone)[1]
    np.testing.assert_allclose(found.log_determinant - gusts.log_determinant, added, atol=1e-8)
