"""What long logs cost is measured by `make lab-bench`; here only that the log is long and the
ratios are found.
"""

import numpy as np
import pytest

from pitotbench.campaigns.flights import sense
from pitotlab.speed.growth import cross_check_growth, reading_times, tiled


@pytest.fixture(scope="module")
def log(smooth_flights):
    return sense(smooth_flights["circle"], "20/1")


def test_a_tiled_log_repeats_the_rows_without_a_pause(log):
    long = tiled(log, 2 * len(log) + 5)
    assert len(long) == 2 * len(log) + 5
    assert np.diff(long.time)[len(log) - 1] == pytest.approx(np.median(np.diff(log.time)))
    np.testing.assert_array_equal(
        long.impact_pressure[len(log) : 2 * len(log)], log.impact_pressure
    )


def test_ratios_are_measured(log, tmp_path):
    times = reading_times(log, tmp_path / "log.csv")
    assert min(times.arrow, times.read, times.calibrate) > 0.0
    assert (
        0.0 < cross_check_growth(log, len(log), 2) < 10.0
    )  # the limit of 1.3 belongs to `make lab-bench`
