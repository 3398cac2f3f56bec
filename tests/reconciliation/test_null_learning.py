"""Sizes that null flights still seem to have are found in white noise, and none where there is none."""

import numpy as np
import pytest

from pitotbench.estimation.information import Information
from pitotbench.reconciliation.null_learning import lasting_scores, left_over
from pitotbench.reconciliation.thresholds import THRESHOLDS


def test_a_size_that_null_flights_still_seem_to_have_is_found_and_becomes_usual() -> None:
    """Eight flights of white noise, in which one size of four stands at about 5σ and one like it
    follows it.
    """
    random = np.random.default_rng(4)
    columns = random.normal(size=(200, 4)) / np.sqrt(200.0)
    columns[:, 3] = 0.9 * columns[:, 2] + 0.3 * columns[:, 3]
    logs = [random.normal(size=200) + 5.0 * random.normal() * columns[:, 2] for _ in range(8)]
    every = [np.concatenate([columns, log[:, None]], axis=1) for log in logs]
    flights = [Information(each.T @ each) for each in every]
    found, after = left_over(("a", "b", "c", "d"), flights)
    assert list(found) == ["c"]
    scores = np.array([each.inner[2, -1] / np.sqrt(each.inner[2, 2]) for each in flights])
    assert found["c"] == pytest.approx(np.sqrt(np.mean(scores**2)))
    usual = np.array([each.inner[:-1, -1] / np.sqrt(np.diag(each.inner)[:-1]) for each in after])
    assert usual[:, 2] == pytest.approx(scores / found["c"])
    assert np.all(np.sqrt(np.mean(usual**2, axis=0)) < THRESHOLDS.left_over_from)


def test_flights_of_white_noise_leave_nothing_over() -> None:
    random = np.random.default_rng(5)
    every = random.normal(size=(8, 300, 40))
    flights = [Information(each.T @ each) for each in every]
    assert not left_over(tuple(map(str, range(39))), flights)[0]


def test_what_eight_flights_have_in_common_is_kept_of_their_mean_score_and_chance_is_not() -> None:
    """Three terms that nearly cancel, whose small sum all flights pull, and two sizes that are alike."""
    random = np.random.default_rng(6)
    columns = 100.0 * random.normal(size=(300, 6)) / np.sqrt(300.0)
    total = 8.0 * random.normal(size=300) / np.sqrt(300.0)
    columns[:, 2] = total - columns[:, 0] - columns[:, 1]
    columns[:, 4] = columns[:, 3] + 1e-3 * columns[:, 4]
    flights, pulls = [], []
    for pull in (-0.6, 0.0):
        noise = random.normal(size=(8, 300)) + pull * total
        every = [np.concatenate([columns, each[:, None]], axis=1) for each in noise]
        flights.append([Information(each.T @ each) for each in every])
        pulls.append(pull * columns.T @ total)
    found, products = lasting_scores(flights[0])
    assert found[:3].sum() == pytest.approx(pulls[0][:3].sum(), rel=0.15)
    assert products == pytest.approx(np.mean([each.inner[:-1, :-1] for each in flights[0]], axis=0))
    assert not lasting_scores(flights[1])[0].any()
