"""Several flights together: the sums against dense algebra on stacked logs, contradictions, flights
left out.
"""

import numpy as np
import pytest
from scipy.stats import norm

from pitotbench.estimation.information import Information
from pitotbench.reconciliation.closure import closes, closure_of
from pitotbench.reconciliation.equations import equations_from, inner_products
from pitotbench.reconciliation.other_flights import contradiction
from pitotbench.reconciliation.regression import Sizes
from pitotbench.records.verdict import Closure


def own(value: float, deviation: float) -> Sizes:
    return Sizes((("gps_latency", "latency_s"),), np.array([value]), np.array([[deviation**2]]))


def test_a_contradiction_is_the_distance_of_two_sizes_in_their_deviations() -> None:
    assert contradiction(own(0.3, 0.03), own(0.0, 0.04)) == pytest.approx(6.0)


def test_by_chance_sizes_are_as_far_apart_as_normal_numbers() -> None:
    random, covariance = np.random.default_rng(5), np.array([[1.0, 0.4], [0.4, 2.0]])
    keys = (("a", "x"), ("a", "y"))
    draws = random.multivariate_normal(np.zeros(2), covariance, size=(4000, 2))
    found = [
        contradiction(Sizes(keys, one, covariance), Sizes(keys, two, covariance))
        for one, two in draws
    ]
    for limit in (0.5, 1.0, 2.0):
        expected = 2.0 * norm.sf(limit)
        assert np.mean(np.array(found) > limit) == pytest.approx(
            expected, abs=4.0 * np.sqrt(expected / 4000)
        )


@pytest.mark.parametrize(
    ("closure", "closed"),
    [
        (Closure(1400.0, 1010.0, 1000.0), True),
        (Closure(1400.0, 1200.0, 1000.0), False),
        (Closure(1010.0, 1900.0, 1005.0), False),  # the effect is not there
        (Closure(1012.0, 1011.0, 1000.0), True),  # the log shows nothing of it
        (Closure(1400.0, 1200.0, 1000.0, chance=25.0), True),  # the sizes are hardly known
        (Closure(1400.0, 1200.0, 1000.0, chance=15.0), False),
    ],
)
def test_a_log_takes_a_name_back_where_more_than_chance_is_left(
    closure: Closure, closed: bool
) -> None:
    assert closes(closure) == closed


def test_uncertain_sizes_leave_as_much_as_draws_of_them_do() -> None:
    random = np.random.default_rng(6)
    columns, residual = random.normal(size=(60, 2, 4)), random.normal(size=(60, 2))
    equations = equations_from(inner_products(columns, residual), 2, np.array([1.0, 2.0]))
    covariance = np.array([[0.04, 0.01], [0.01, 0.02]])
    sizes = np.array([0.7, -0.3])
    expected = closure_of(Information(equations.inner), (0, 1), sizes.tolist(), (), covariance)
    draws = random.multivariate_normal(sizes, covariance, size=5_000)
    left = np.array(
        [
            closure_of(Information(equations.inner), (0, 1), drawn.tolist(), ()).after
            for drawn in draws
        ]
    )
    error = np.std(left) / np.sqrt(len(left))
    assert np.mean(left) - expected.after == pytest.approx(expected.chance, abs=4.0 * error)


def test_an_event_of_a_flight_is_no_part_of_what_the_others_can_close() -> None:
    random = np.random.default_rng(7)
    columns, residual = random.normal(size=(60, 2, 5)), random.normal(size=(60, 2))
    residual += columns @ np.array([0.0, 0.0, 0.8, -0.5, 30.0])
    equations = equations_from(inner_products(columns, residual), 2, np.array([1.0, 2.0]))
    fit = equations.fit((0, 1, 2))
    closed = closure_of(
        Information(equations.inner), (0, 1), fit.sizes[:2].tolist(), (), given=(2,)
    )
    assert closed.before == pytest.approx(
        equations.inner[-1, -1] - Information(equations.inner).gain((2,))
    )
    assert closed.after == pytest.approx(
        equations.inner[-1, -1] - Information(equations.inner).gain((0, 1, 2))
    )
    apart = closure_of(
        Information(equations.inner), (0, 1), (fit.sizes[:2] + 0.3).tolist(), (), given=(2,)
    )
    assert closed.after < apart.after < closed.before


def test_what_every_flight_has_in_a_place_is_no_gap_that_an_effect_could_close() -> None:
    """An effect of 10σ closed three quarters beside a place that stands at 6σ on every flight."""
    random = np.random.default_rng(8)
    columns = random.normal(size=(400, 1, 2)) / np.sqrt(400.0)
    residual = random.normal(size=(400, 1)) + columns @ np.array([10.0, 6.0])
    inner = inner_products(columns, residual)[0]
    plain, shares = Information(inner), []
    for evidence in (plain, plain.given((1,), (6.0,), (0, 1))[0]):
        size = evidence.inner[0, -1] / evidence.inner[0, 0]
        shares.append(closure_of(evidence, (0,), (size,), (1,)).share)
    assert shares[0] < 0.8
    assert shares[1] > 0.95
