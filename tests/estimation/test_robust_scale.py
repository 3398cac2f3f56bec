"""The robust deviation is that of the noise, whatever the outliers are."""

import numpy as np
import pytest

from pitotbench.estimation.noise import robust_deviation

NOISE = np.random.default_rng(5).normal(7.0, 2.0, (20_000, 2))


def test_it_is_the_standard_deviation_of_normal_noise() -> None:
    assert robust_deviation(NOISE) == pytest.approx([2.0, 2.0], rel=0.03)


def test_outliers_do_not_enlarge_it_without_bound() -> None:
    spoiled = NOISE.copy()
    spoiled[: len(spoiled) // 10] = 1e9
    assert np.all(robust_deviation(spoiled) < 1.25 * robust_deviation(NOISE))
