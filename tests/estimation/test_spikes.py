"""The scale of noise from the sizes of differences, and the samples that stand out from both neighbors."""

import numpy as np
import pytest

from pitotbench.estimation.noise import deviation_of_sizes, spikes_among


def test_the_scale_is_that_of_normal_noise_whatever_a_few_outliers_do():
    sizes = np.abs(np.random.default_rng(1).standard_normal(20_000))
    assert deviation_of_sizes(sizes) == pytest.approx(1.0, abs=0.03)
    sizes[::100] = 1e6
    assert deviation_of_sizes(sizes) == pytest.approx(1.0, abs=0.15)


def test_rounded_data_whose_median_difference_is_zero_still_have_a_scale():
    sizes = np.where(np.arange(1000) % 10 == 0, 1.0, 0.0)
    assert deviation_of_sizes(sizes) == pytest.approx(1.0 / 1.96)


def test_of_a_spike_and_its_neighbors_only_the_spike_is_found():
    values = np.zeros(20)
    values[7] = 5.0
    second = np.abs(np.diff(values, 2))
    assert list(np.flatnonzero(spikes_among(second, 1.0))) == [7]
    assert not spikes_among(second, np.inf).any()
