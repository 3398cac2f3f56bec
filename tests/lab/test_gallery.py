"""The gallery holds answers of real logs against their truths as it says."""

from zipfile import ZipFile

import numpy as np
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
    """Words are shared, numbers may have exponents, a cell may be missing in a column of words."""
    main = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
    words = "".join(f"<si><t>{word}</t></si>" for word in ("Vic", "Hic", "pilot", "Ann"))
    cells = (
        '<c r="A1" t="s"><v>0</v></c><c r="B1" t="s"><v>1</v></c><c r="C1" t="s"><v>2</v></c>'
        '<c r="A2"><v>298.25</v></c><c r="B2"><v>2.2E3</v></c><c r="C2" t="s"><v>3</v></c>'
        '<c r="A3"><v>347</v></c><c r="B3"><v>2250</v></c><c r="C3"/>'
    )
    path = tmp_path / "card.xlsx"
    with ZipFile(path, "w") as book:
        book.writestr("xl/sharedStrings.xml", f"<sst {main}>{words}</sst>")
        book.writestr("xl/worksheets/sheet1.xml", f"<worksheet {main}>{cells}</worksheet>")
    found = gallery._sheet(path)
    assert {name: list(values) for name, values in found.items()} == {
        "Vic": [298.25, 347.0],
        "Hic": [2200.0, 2250.0],
    }
