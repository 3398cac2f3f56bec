"""Several flights together: the sums against dense algebra on stacked logs, contradictions, flights
left out.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from pitotbench import Case, fly, sense
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.equations import (
    closure_of,
    equations_from,
    inner_products,
    noise_of_log,
)
from pitotbench.reconciliation.evidence import Evidence
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.naming import OwnSizes, contradiction
from pitotbench.reconciliation.null_distribution import NullDistribution, ScoreScale
from pitotbench.reconciliation.pictures import waterfall
from pitotbench.reconciliation.verdict import closes, judge, verdict_of
from pitotbench.records.case import EffectSpec
from pitotbench.records.verdict import Closure

FEW = Catalog(
    "effect", {n: EFFECTS[n] for n in ("pitot_lag", "gps_latency", "wind_drift", "static_lag")}
)
HIDDEN = EffectSpec("gps_latency", {"latency_s": 0.3})


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_evidence_of_several_logs_is_that_of_one_stacked_log(seed: int) -> None:
    """Dense covariances of the stacked residuals, with the free columns of each log its own."""
    random = np.random.default_rng(seed)
    rows, free, sizes = (11, 17, 8), 3, 2
    deviations, own = np.array([0.6, 1.7]), np.array([2.0, 0.5, 1.0])
    total, log_evidence = Evidence(np.zeros((sizes + 1, sizes + 1))), 0.0
    shared, nuisance, residuals = [], [], []
    for n in rows:
        x, f, r = (
            random.normal(size=(n, sizes)),
            random.normal(size=(n, free)),
            random.normal(size=n),
        )
        every = np.concatenate([f, x, r[:, None]], axis=1)
        one, part = Evidence(every.T @ every).given(range(free), own, range(free, free + sizes))
        total, log_evidence = total + one, log_evidence + part
        shared.append(x)
        nuisance.append(f)
        residuals.append(r)
    found = total.of(range(sizes), deviations)
    x, r = np.concatenate(shared), np.concatenate(residuals)
    plain = np.eye(sum(rows))
    start = 0
    for f in nuisance:
        end = start + len(f)
        plain[start:end, start:end] += f @ np.diag(own**2) @ f.T
        start = end
    whole = plain + x @ np.diag(deviations**2) @ x.T
    nothing = multivariate_normal(np.zeros(len(r)), np.eye(len(r))).logpdf(r)
    expected = multivariate_normal(np.zeros(len(r)), whole).logpdf(r) - nothing
    assert found.log_evidence + log_evidence == pytest.approx(expected, abs=1e-8)
    gain = np.diag(deviations**2) @ x.T @ np.linalg.inv(whole)
    assert found.mean == pytest.approx(gain @ r, abs=1e-9)


def own(value: float, deviation: float) -> OwnSizes:
    return OwnSizes((("gps_latency", "latency_s"),), np.array([value]), np.array([[deviation**2]]))


def test_a_contradiction_is_the_distance_of_two_sizes_in_their_deviations() -> None:
    assert contradiction(own(0.3, 0.03), own(0.0, 0.04)) == pytest.approx(6.0)
    other = OwnSizes((("pitot_lag", "lag_s"),), np.array([1.0]), np.eye(1))
    assert contradiction(own(0.3, 0.03), other) == 0.0


def test_by_chance_sizes_are_as_far_apart_as_normal_numbers() -> None:
    random, covariance = np.random.default_rng(5), np.array([[1.0, 0.4], [0.4, 2.0]])
    keys = (("a", "x"), ("a", "y"))
    draws = random.multivariate_normal(np.zeros(2), covariance, size=(4000, 2))
    found = [
        contradiction(OwnSizes(keys, one, covariance), OwnSizes(keys, two, covariance))
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
    told = " ".join(joint.verdict.notes)
    assert "flight 2 contradicts gps_latency" in told
    assert "σ from the other flights" in told


def test_a_flight_that_cannot_show_a_cause_leaves_it_to_the_others(flights) -> None:
    blind = Catalog("effect", {n: FEW[n] for n in FEW if n != "gps_latency"})
    joint = judged(flights[0], laid("step_decrease", 2302, shown=blind))
    assert [effect.name for effect in joint.verdict.effects] == ["gps_latency"]
    assert joint.verdict.kind == "named"
    steps = [[step.effect for step in waterfall(naming)] for naming in joint.together.namings]
    assert steps == [["gps_latency"], []]


def test_the_order_of_the_flights_does_not_matter(flights, both) -> None:
    one, other = both.verdict, judged(*flights[1::-1]).verdict
    assert one.effects[0].sizes[0].value == pytest.approx(other.effects[0].sizes[0].value, rel=1e-6)
    assert one.log_bayes_factor == pytest.approx(other.log_bayes_factor, rel=1e-6)


def test_a_name_is_withdrawn_with_its_reason_and_a_doubted_one_only_probable(alone) -> None:
    checks = alone.checks
    back = verdict_of(replace(checks, contradictions=("flight 2 contradicts it",)))
    assert (back.kind, back.effects) == ("unknown", ())
    assert back.notes[-1].startswith("flight 2 contradicts it: the name gps_latency")
    assert back.changes == ("named -> unknown: flight 2 contradicts it",)
    why = "the sizes of the other flights close only 50% of the gap of flight 2"
    doubtful = replace(checks, left_out=(why,))
    less, told = verdict_of(doubtful), verdict_of(replace(doubtful, left=0.02))
    assert (less.kind, less.effects, less.remains) == ("one_of", checks.found.effects, True)
    assert less.doubts == (why,)
    assert told.effects[0].probability < 0.65
    assert told.alternatives[0]
    quiet = replace(checks.found, kind="no_gap", effects=(), alternatives=())
    assert verdict_of(replace(checks, found=quiet, contradictions=("why",))).kind == "no_gap"
    assert not verdict_of(replace(doubtful, found=quiet)).doubts
