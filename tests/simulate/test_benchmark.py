"""Recording all channels at 100 Hz stays cheap beside JSBSim itself."""

from pitotbench.simulate import overhead_ratio


def test_a_recorded_flight_costs_little_more_than_bare_jsbsim():
    ratio = overhead_ratio()
    print(f"recorded flight / bare loop: {ratio:.2f}")
    assert ratio < 1.6  # the aim is 1.35, measured by the benchmark script; a shared machine is noisy
