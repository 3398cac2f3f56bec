"""Rows that disagree in numbers that leave no answer."""

import numpy as np
import pytest
from tests.calibration.test_screening import _log, _with

from pitotbench import BadInputError, NoAnswerError
from pitotbench.calibration import calibrate


def test_when_too_much_disagrees_there_is_no_answer():
    log = _log()
    rows = np.flatnonzero((log.time % 20.0) < 9.0)
    with pytest.raises(
        (BadInputError, NoAnswerError), match=r"disagree with the rest|gross errors"
    ):
        calibrate(_with(log, rows, 2.5))
