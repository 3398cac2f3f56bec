"""The scale of noise, samples that stand out from both neighbors, and the Yule-Walker equations."""

import numpy as np
import pytest

from pitotbench.estimation.noise import (
    RIDGE,
    yule_walker,
)
from pitotbench.scatter import (
    deviation_of_sizes,
    robust_deviation,
    spikes_among,
    white_differences,
)


def test_the_scale_is_that_of_normal_noise_whatever_a_few_outliers_do():
    sizes = np.abs(np.random.default_rng(1).standard_normal(20_000))
    assert deviation_of_sizes(sizes) == pytest.approx(1.0, abs=0.03)
    sizes[::100] = 1e6
    assert deviation_of_sizes(sizes) == pytest.approx(1.0, abs=0.15)
    # Rounded data whose median difference is zero still have a scale.
    sizes = np.where(np.arange(1000) % 10 == 0, 1.0, 0.0)
    assert deviation_of_sizes(sizes) == pytest.approx(1.0 / 1.96)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_white_noise_keeps_its_deviation_and_a_slow_signal_cancels(order):
    noise = 2.0 * np.random.default_rng(4).standard_normal(20_000)
    slow = 1e3 * np.linspace(-1.0, 1.0, 20_000) ** (order - 1)
    found = white_differences(slow + noise, order)
    assert len(found) == 20_000 - order
    assert np.std(found) == pytest.approx(2.0, rel=0.03)


def test_of_a_spike_and_its_neighbors_only_the_spike_is_found():
    values = np.zeros(20)
    values[7] = 5.0
    second = np.abs(np.diff(values, 2))
    assert list(np.flatnonzero(spikes_among(second, 1.0))) == [7]
    assert not spikes_among(second, np.inf).any()


NOISE = np.random.default_rng(5).normal(7.0, 2.0, (20_000, 2))


def test_a_deviation_is_that_of_normal_noise_and_outliers_do_not_enlarge_it_without_bound() -> None:
    assert robust_deviation(NOISE) == pytest.approx([2.0, 2.0], rel=0.03)
    spoiled = NOISE.copy()
    spoiled[: len(spoiled) // 10] = 1e9
    assert np.all(robust_deviation(spoiled) < 1.25 * robust_deviation(NOISE))


def test_a_process_of_second_order_is_found_from_its_autocovariance() -> None:
    """x[i] = a x[i-1] + b x[i-2] + e with e of deviation s: its autocovariance follows in closed
    form.
    """
    a, b, s = 0.9, -0.4, 0.5
    first = a / (1.0 - b)
    variance = s**2 / (1.0 - a * first - b * (a * first + b))
    correlation = [1.0, first]
    for _ in range(4):
        correlation.append(a * correlation[-1] + b * correlation[-2])
    coefficients, deviation = yule_walker(variance * np.array(correlation))
    assert coefficients == pytest.approx([a, b, 0.0, 0.0, 0.0], abs=10.0 * RIDGE)
    assert deviation == pytest.approx(s, rel=10.0 * RIDGE)
    # A channel that does not change has a deviation above zero.
    coefficients, deviation = yule_walker(np.zeros(4))
    assert np.all(np.isfinite(coefficients))
    assert deviation > 0.0
