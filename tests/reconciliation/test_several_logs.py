"""Several flights together: the sums against dense algebra on stacked logs, contradictions, flights
left out.
"""

import numpy as np
import pytest
from scipy.stats import norm

from pitotbench import Case, fly, sense
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.equations import (
    closure_of,
    equations_from,
    inner_products,
    noise_of_log,
)
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.null_distribution import NullDistribution, ScoreScale
from pitotbench.reconciliation.pictures import waterfall
from pitotbench.reconciliation.regression import Sizes
from pitotbench.reconciliation.verdict import closes, contradiction, judge
from pitotbench.records.case import EffectSpec
from pitotbench.records.verdict import Closure

FEW = Catalog(
    "effect", {n: EFFECTS[n] for n in ("pitot_lag", "gps_latency", "wind_drift", "static_lag")}
)
HIDDEN = EffectSpec("gps_latency", {"latency_s": 0.3})


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
    expected = closure_of(equations, (0, 1), sizes.tolist(), (), covariance)
    draws = random.multivariate_normal(sizes, covariance, size=5_000)
    left = np.array([closure_of(equations, (0, 1), drawn.tolist(), ()).after for drawn in draws])
    error = np.std(left) / np.sqrt(len(left))
    assert np.mean(left) - expected.after == pytest.approx(expected.chance, abs=4.0 * error)


def test_an_event_of_a_flight_is_no_part_of_what_the_others_can_close() -> None:
    random = np.random.default_rng(7)
    columns, residual = random.normal(size=(60, 2, 5)), random.normal(size=(60, 2))
    residual += columns @ np.array([0.0, 0.0, 0.8, -0.5, 30.0])
    equations = equations_from(inner_products(columns, residual), 2, np.array([1.0, 2.0]))
    fit = equations.fit((0, 1, 2))
    closed = closure_of(equations, (0, 1), fit.sizes[:2].tolist(), (), beside=(2,))
    assert closed.before == pytest.approx(equations.remaining((2,)))
    assert closed.after == pytest.approx(equations.remaining((0, 1, 2)))
    apart = closure_of(equations, (0, 1), (fit.sizes[:2] + 0.3).tolist(), (), beside=(2,))
    assert closed.after < apart.after < closed.before


def laid(maneuver: str, seed: int, *effects: EffectSpec, shown: Catalog = FEW):
    case = Case(
        maneuver=maneuver, turbulence="light", truth_seed=seed, sensor_seed=seed, effects=effects
    )
    layout = lay_out(sense(fly(case), "20/20"), None, AnalysisSetting(day_known=True), shown)
    return layout, NullDistribution(
        noise_of_log(layout), ScoreScale({}, {}, {}, {}), 6.0, 6.0, flights=8
    )


@pytest.fixture(scope="module")
def flights():
    return (
        laid("rapid_decel", 2301, HIDDEN),
        laid("step_decrease", 2302, HIDDEN),
        laid("rapid_decel", 2303),
    )


def judged(*flights):
    names = [f"flight {i}" for i in range(1, len(flights) + 1)]
    return judge(names, [layout for layout, _ in flights], [null for _, null in flights])


@pytest.fixture(scope="module")
def both(flights):
    return judged(*flights[:2])


@pytest.fixture(scope="module")
def alone(flights):
    return judged(flights[0])


def test_two_flights_share_a_cause_and_its_size(flights, both, alone) -> None:
    joint = both
    assert joint.verdict.kind == "named"
    (effect,) = joint.verdict.effects
    assert effect.name == "gps_latency"
    assert effect.sizes[0].value == pytest.approx(0.3, abs=effect.sizes[0].two_sigma)
    apart = [each.verdict.effects[0].sizes[0].value for each in (alone, judged(flights[1]))]
    assert min(apart) - 1e-3 <= effect.sizes[0].value <= max(apart) + 1e-3
    for flight in joint.flights:
        assert flight.left_out.share > 0.85
        assert all(own.apart is not None and own.apart < 3.0 for own in flight.own_sizes)


def test_a_cause_that_a_flight_does_not_show_is_not_named_and_the_flight_is(flights) -> None:
    joint = judged(flights[0], flights[2])
    assert joint.verdict.kind == "unknown"
    assert joint.verdict.effects == ()
    told = " ".join(joint.verdict.doubts)
    assert "flight 2 contradicts gps_latency" in told
    assert "σ from the other flights" in told
    assert "is taken back" in told


def test_a_flight_that_cannot_show_a_cause_leaves_it_to_the_others(flights) -> None:
    blind = Catalog("effect", {n: FEW[n] for n in FEW if n != "gps_latency"})
    joint = judged(flights[0], laid("step_decrease", 2302, shown=blind))
    assert [effect.name for effect in joint.verdict.effects] == ["gps_latency"]
    assert joint.verdict.kind == "named"
    steps = [[step.effect for step in waterfall(each.block, each.fit)] for each in joint.shown]
    assert steps == [["gps_latency"], []]


def test_the_order_of_the_flights_does_not_matter(flights, both) -> None:
    one, other = both.verdict, judged(*flights[1::-1]).verdict
    assert one.effects[0].sizes[0].value == pytest.approx(other.effects[0].sizes[0].value, rel=1e-6)
    assert one.log_bayes_factor == pytest.approx(other.log_bayes_factor, rel=1e-6)
