"""How cost grows is measured by a script; here only that an exponent is right, and that small logs
are timed.
"""

import numpy as np
import pytest

from pitotbench.campaigns.flights import sense
from pitotbench.logbook.formats import write_log
from pitotlab.speed.growth import Cost, costs_by_samples, exponent, peak_megabytes


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_the_exponent_is_that_of_the_costs(power):
    assert exponent([Cost("job", n, 3e-6 * n**power) for n in (10, 100, 1000)]) == pytest.approx(
        power
    )


def test_reading_and_calibrating_are_measured(smooth_flights):
    costs = list(costs_by_samples(sense(smooth_flights["circle"], "20/1"), (8000,)))
    assert [cost.job for cost in costs] == ["read", "calibrate"]
    assert all(cost.seconds > 0.0 and cost.megabytes > 10.0 for cost in costs)


def test_the_peak_of_a_new_process_is_its_own(smooth_flights, tmp_path):
    write_log(sense(smooth_flights["circle"], "20/1"), tmp_path / "log.csv")
    held = np.ones(75_000_000)  # 600 MB of this process
    assert peak_megabytes(tmp_path / "log.csv") < 1e-6 * held.nbytes
