"""What recording costs beside JSBSim itself is measured by `make bench`; here only that it can be."""

from pitotbench.evidence.speed.flight_overhead import overhead_ratio


def test_recording_costs_something_and_is_measured():
    ratio = overhead_ratio()
    print(f"recorded flight / bare loop: {ratio:.2f}")
    assert 1.0 < ratio < 10.0  # the limit of 1.35 belongs to `make bench`: no test is timed
