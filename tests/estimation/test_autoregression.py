"""The Yule-Walker equations against a process whose autocovariance is known."""

import numpy as np
import pytest

from pitotbench.estimation.noise import RIDGE, yule_walker


def test_a_process_of_second_order_is_found_from_its_autocovariance() -> None:
    """x[i] = a x[i-1] + b x[i-2] + e with e of deviation s: its autocovariance follows in closed form."""
    a, b, s = 0.9, -0.4, 0.5
    first = a / (1.0 - b)
    variance = s**2 / (1.0 - a * first - b * (a * first + b))
    correlation = [1.0, first]
    for _ in range(4):
        correlation.append(a * correlation[-1] + b * correlation[-2])
    coefficients, deviation = yule_walker(variance * np.array(correlation))
    assert coefficients == pytest.approx([a, b, 0.0, 0.0, 0.0], abs=10.0 * RIDGE)
    assert deviation == pytest.approx(s, rel=10.0 * RIDGE)


def test_a_channel_that_does_not_change_has_a_deviation_above_zero() -> None:
    coefficients, deviation = yule_walker(np.zeros(4))
    assert np.all(np.isfinite(coefficients))
    assert deviation > 0.0
