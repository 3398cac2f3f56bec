"""Effects at both ends of their range get an answer; `python -m tests.lab.both_ends` does the whole
table.
"""

import pytest
from tests.lab.both_ends import judged

from pitotbench.records.verdict import SURE


# An end of each; the table has the others.
@pytest.mark.parametrize(
    ("name", "end"),
    [
        ("compass_deviation", "high"),
        ("alpha_vane_calibration", "low"),
        ("alpha_vane_calibration", "high"),
    ],
)
def test_an_extreme_instrument_gets_an_answer(name, end):
    assert judged(name, end, "none").error == ""


# Where the gap counted as the noise of so short a log, it was passed over in silence; so was a late
# receiver, which the product's own tests hold.
def test_a_compass_that_deviates_is_first_in_two_minutes_without_null_flights():
    found = judged("compass_deviation", "high", "none")
    assert found.verdict in SURE
    assert found.causes[0] == "compass_deviation"
