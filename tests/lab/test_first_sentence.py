"""What is said first of a log: one cause is one sentence, whatever checks have found it."""

import pytest
from tests.shared_data import shared_case

from pitotbench import BadInputError, read_log
from pitotbench.bench.calibrations import calibrate_each
from pitotbench.show.calibration import doubts_of

# Case: what the first sentence holds, and the factor with which it was made, None for no factor.
FIRST = {
    "02-g3x-touch-whole-mps.csv": ("", None),
    "07a-qgroundcontrol.csv": ("Multiply the airspeed by", 1.0 / 0.88),
    "09-edgetx.csv": ("Multiply the airspeed by", 1.0 / 0.88),
    "12-airspeed-reads-half.bin": ("half of the airspeed does so", 2.0),
    "13a-pitot-ices-halfway.bin": ("the airspeed dies", None),
    "19-tas-in-the-ias-column.csv": ("true airspeed in the column of the indicated one", None),
    "28-default-ratio": ("Multiply the airspeed by", 0.905),
    "32-car-on-a-road.csv.gz": ("Multiply the airspeed by", 1.0 / 0.84),
}
REFUSED = ("13a-pitot-ices-halfway.bin",)
OF_SIZE = ("pressure error is", "wrong old parameter", "zero offset")


@pytest.mark.parametrize("name", list(FIRST))
def test_the_first_sentence_names_the_cause_and_no_other_names_it_again(name):
    path, (first, factor) = shared_case(name), FIRST[name]
    if name in REFUSED:
        with pytest.raises(BadInputError, match=first):
            read_log(path)
        return
    found = calibrate_each([read_log(path)])[0].calibration
    told = doubts_of(found)
    assert first in told[0] if first else not told
    assert not any(words in each for each in told[1:] for words in OF_SIZE)
    if factor is not None:
        assert found.usable
        assert abs(found.scale.factor - factor) <= found.scale.two_sigma
