"""What recording costs beside JSBSim itself is measured by `make bench`; here only that it can be."""

from pitotbench.evidence.speed.flight_overhead import overhead_ratio
from pitotbench.sense import CALIBRATION_CHANNELS


def test_recording_costs_something_and_is_measured():
    ratio = overhead_ratio(pairs=3)
    print(f"recorded flight / bare loop: {ratio}")
    assert 1.0 < ratio.least < 10.0  # the limit belongs to `make bench`: no test is timed
    assert len(overhead_ratio(pairs=1, channels=CALIBRATION_CHANNELS).pairs) == 1
