"""One flight in every format: the readings within the steps of the file, the correction within its
bound.
"""

from dataclasses import astuple

import numpy as np
import pytest
from tests.lab import formats
from tests.lab.formats import EXACT, FORMATS, Readings, compare, table

NEEDS = {".bin": "pymavlink", ".ulg": "pyulog", ".mat": "h5py"}


@pytest.fixture(scope="module")
def flown():
    return formats.flight()


@pytest.mark.parametrize("name", FORMATS)
def test_a_format_gives_the_numbers_of_the_csv(tmp_path, flown, name):
    if module := NEEDS.get(FORMATS[name].suffix):
        pytest.importorskip(module)
    result = compare(name, flown, tmp_path)
    for apart, step in zip(astuple(result.difference), astuple(result.steps), strict=True):
        assert np.isnan(apart) or apart <= max(step, EXACT)
    assert np.all(result.share < 1.0)
    if not any(astuple(result.steps)):
        assert np.max(result.correction_kt) < EXACT


def test_the_table_shows_what_is_exact_and_what_is_a_step():
    steps = Readings(1.0, 10.0, 1.0, 1.0, 1.0)
    apart = Readings(0.5, 0.0, float("nan"), 0.25, 1e-12)
    result = formats.Result(
        "a card", 1830, apart, steps, np.array([0.02, 0.0, 0.01]), np.array([0.1, 0.0, 0.2])
    )
    *_, line = table([result]).splitlines()
    assert (
        line == "| a card | 1,830 | 0.5 (0.50) | exact | not held | 0.25 (0.25) | exact | 0.02, 0, "
        "0.01 | 0.2 |"
    )
