"""The gallery holds answers of real logs against their truths as it says."""

import numpy as np
import openpyxl
import pytest

from pitotlab import gallery
from pitotlab.gallery import Held


def held(off: float) -> Held:
    at = np.array([80.0, 100.0, 120.0])
    truth, ones = np.array([1.0, 2.0, 3.0]), np.ones(3)
    found = truth + np.array([0.0, 0.0, off])
    return Held(at, found, 0.6 * ones, truth, 0.8 * ones, "speed [kt]", "")


@pytest.mark.parametrize(("off", "says"), [(0.99, "**Inside**"), (-1.01, "**Outside** at 1 of 3")])
def test_a_truth_outside_both_bounds_stands_as_outside(off, says):
    told = gallery._verdict(held(off))
    assert told.startswith(says)
    if off < 0.0:
        assert "farthest at 120 (speed [kt]): +2.0 ± 0.6, where the truth is +3.0 ± 0.8" in told


def test_an_absent_log_is_named(tmp_path):
    lines = list(gallery._section(gallery.ENTRIES[0], tmp_path, draw=False))
    assert lines[-1] == f"Left out: {gallery.ENTRIES[0].path} is not in the folder of logs."


def test_one_place_is_told_without_a_count():
    single = Held(*(np.array([value]) for value in (1.0, 6.4, 0.3, 6.5, 0.2)), "maneuver", "")
    assert gallery._verdict(single) == "**Inside.**"


def test_a_sheet_gives_its_columns_of_numbers(tmp_path):
    """A cell may be missing in a column of words, and a column may be shorter than another."""
    book = openpyxl.Workbook()
    for row in (["Vic", "Hic", "pilot"], [298.25, 2.2e3, "Ann"], [347, 2250, None], [None, 2300]):
        book.active.append(row)
    book.save(path := tmp_path / "card.xlsx")
    found = gallery._sheet(path)
    assert {name: list(values) for name, values in found.items()} == {
        "Vic": [298.25, 347.0],
        "Hic": [2200.0, 2250.0, 2300.0],
    }
