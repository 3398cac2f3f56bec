"""Spreads, ratios and rank orders."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kendalltau

from pitotlab.study.tables import Spread, airspeed_noise, percent_above, rank_agreement, ratio


def test_spread_is_the_sample_standard_deviation():
    values = [1.0, 2.0, 4.0]
    spread = Spread.of([*values, float("nan")])
    assert (spread.mean, spread.count) == (pytest.approx(7.0 / 3.0), 3)
    assert spread.deviation == pytest.approx(np.std(values, ddof=1))
    assert spread.error == pytest.approx(spread.deviation / np.sqrt(3.0))


def test_one_seed_has_no_spread():
    assert Spread.of([0.5]).text(2) == "0.50"
    assert Spread.of([0.5, 0.7]).text(1, " kt") == "0.6 ± 0.1 kt"


def test_ratios_pair_the_seeds():
    one, other = pd.Series({1: 2.0, 2: 8.0, 3: 1.0}), pd.Series({2: 4.0, 1: 1.0})
    assert ratio(one, other).mean == pytest.approx(2.0)
    assert ratio(one, other).deviation == pytest.approx(0.0)
    assert percent_above(one, other).mean == pytest.approx(100.0)


@given(st.permutations(range(6)))
def test_rank_agreement_is_kendalls(order):
    reference = np.arange(6.0)
    expected = kendalltau(order, reference).statistic
    assert rank_agreement(np.array(order, dtype=float), reference) == pytest.approx(expected)


def test_noise_in_knots_is_that_of_the_data_system():
    """sensing/sampling.py states 0.36 kt at 100 KCAS and 0.22 kt at 160 KCAS, 1σ."""
    slow, fast = (airspeed_noise(np.array([v]), np.array([1.0])) for v in (100.0, 160.0))
    assert 0.5 * slow == pytest.approx(0.36, abs=0.01)
    assert 0.5 * fast == pytest.approx(0.22, abs=0.01)
    both = airspeed_noise(np.array([100.0, 160.0]), np.array([1.0, 1.0]))
    assert both == pytest.approx(np.sqrt(0.5 * (slow**2 + fast**2)))
