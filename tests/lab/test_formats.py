"""One flight in every format: the readings within the steps of the file, the correction within its
bound.
"""

from dataclasses import astuple

import numpy as np
import pytest
from tests.lab import formats
from tests.lab.formats import EXACT, FORMATS, compare

# kt: seconds since 1970 are rounded to 0.2 µs, in which an airspeed changes by as many µkt at most
CLOCK_ROUNDS = float(np.spacing(1.8e9))
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
        exact = CLOCK_ROUNDS if name.startswith("clock") else EXACT
        assert np.max(result.correction_kt) < exact
