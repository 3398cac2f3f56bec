"""What recording costs beside JSBSim itself is measured by `make lab-bench`; here only that it can
be.
"""

from pitotbench.sensing.recorder import CALIBRATION_CHANNELS
from pitotlab.speed.commands import overhead_ratio, step_ratio


def test_recording_costs_something_and_is_measured():
    ratio = overhead_ratio(pairs=3)
    print(f"recorded flight / bare loop: {ratio}")
    assert 1.0 < ratio.least < 10.0  # the limit belongs to `make lab-bench`: no test is timed
    assert len(overhead_ratio(pairs=1, channels=CALIBRATION_CHANNELS).pairs) == 1


def test_the_airplane_of_jsbsim_leaves_no_file_where_it_flies(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert step_ratio(rounds=1, steps=200).least > 0.0
    assert not list(tmp_path.iterdir())
