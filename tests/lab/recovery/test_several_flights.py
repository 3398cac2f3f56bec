"""Several flights judged together: a cause and its size are those of all, whatever one cannot show."""

import pytest

from pitotbench import Case, FlightLog, fly, sense
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.equations import noise_of_log
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.null_distribution import NullDistribution, ScoreScale
from pitotbench.reconciliation.pictures import waterfall
from pitotbench.reconciliation.verdict import judge
from pitotbench.records.case import EffectSpec

FEW = Catalog(
    "effect", {n: EFFECTS[n] for n in ("pitot_lag", "gps_latency", "wind_drift", "static_lag")}
)
HIDDEN = EffectSpec("gps_latency", {"latency_s": 0.3})


def flown(maneuver: str, seed: int, *effects: EffectSpec) -> FlightLog:
    case = Case(
        maneuver=maneuver, turbulence="light", truth_seed=seed, sensor_seed=seed, effects=effects
    )
    return sense(fly(case), "20/20")


def laid(log: FlightLog, shown: Catalog = FEW):
    layout = lay_out(log, None, AnalysisSetting(day_known=True), shown)
    return layout, NullDistribution(
        noise_of_log(layout), ScoreScale({}, {}, {}, {}), 6.0, 6.0, flights=8
    )


@pytest.fixture(scope="module")
def logs():
    return (
        flown("rapid_decel", 2301, HIDDEN),
        flown("step_decrease", 2302, HIDDEN),
        flown("rapid_decel", 2303),
    )


@pytest.fixture(scope="module")
def flights(logs):
    return [laid(log) for log in logs]


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
        assert all(own.distance is not None and own.distance < 3.0 for own in flight.own_sizes)


def test_a_cause_that_a_flight_does_not_show_is_not_named_and_the_flight_is(flights) -> None:
    joint = judged(flights[0], flights[2])
    assert joint.verdict.kind == "unknown"
    assert joint.verdict.effects == ()
    told = " ".join(joint.verdict.doubts)
    assert "flight 2 contradicts gps_latency" in told
    assert "σ from the other flights" in told
    assert "is withdrawn" in told


def test_a_flight_that_cannot_show_a_cause_leaves_it_to_the_others(flights) -> None:
    blind = Catalog("effect", {n: FEW[n] for n in FEW if n != "gps_latency"})
    joint = judged(flights[0], laid(flown("step_decrease", 2302), blind))
    assert [effect.name for effect in joint.verdict.effects] == ["gps_latency"]
    assert joint.verdict.kind == "named"
    steps = [
        [step.effect for step in waterfall(each.block, each.fit, {"gps_latency"})]
        for each in joint.shown
    ]
    assert steps == [["gps_latency"], []]


def test_the_order_of_the_flights_does_not_matter(flights, both) -> None:
    one, other = both.verdict, judged(*flights[1::-1]).verdict
    assert one.effects[0].sizes[0].value == pytest.approx(other.effects[0].sizes[0].value, rel=1e-6)
    assert one.log_bayes_factor == pytest.approx(other.log_bayes_factor, rel=1e-6)
