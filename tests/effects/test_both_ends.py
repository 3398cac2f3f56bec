"""Effects at both ends of their range get an answer; `python -m tests.effects.both_ends` does the whole table."""

import pytest
from tests.effects.both_ends import ENDS, judged


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("name", ["compass_deviation", "alpha_vane_calibration", "inertial_unit_misalignment"])
def test_an_extreme_instrument_gets_an_answer(name, end):
    assert judged(name, end, "none").error == ""
