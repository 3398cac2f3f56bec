"""How cost grows is measured by a script; here only that an exponent is right, and that small logs are timed."""

import pytest

from pitotbench.bench import sense
from pitotbench.evidence.speed.growth import Cost, costs_by_samples, exponent


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_the_exponent_is_that_of_the_costs(power):
    assert exponent([Cost("job", n, 3e-6 * n**power) for n in (10, 100, 1000)]) == pytest.approx(power)


def test_reading_and_calibrating_are_measured(smooth_flights):
    costs = list(costs_by_samples(sense(smooth_flights["circle"], "20/1"), (8000,)))
    assert [cost.job for cost in costs] == ["read", "calibrate"]
    assert all(cost.seconds > 0.0 and cost.megabytes > 10.0 for cost in costs)
