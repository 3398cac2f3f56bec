"""A table of another build is named; one that this build gives again is not."""

from dataclasses import replace

import pytest

from pitotlab import stale as module
from pitotlab.__main__ import main
from pitotlab.made import Made, read_made, said_by_git
from pitotlab.stale import APART, KEPT, Digits, Kept, digits_of, moved, read_digits, stale

KNOWN = Digits("study", "smooth rapid_decel 7700001", 1.0, 0.5)
NOWHERE = Digits("study", "refused", float("nan"), float("nan"))


def test_every_table_says_how_it_was_made():
    made = read_made()
    assert all(all(vars_of(each)) for each in made)
    assert len({each.table for each in made}) == len(made)
    rows = {int(row) for each in made for row in each.rows.split(", ") if row != "–"}
    assert rows == set(range(1, 13))


def vars_of(made):
    return [getattr(made, name) for name in Made.__slots__]


def test_ten_flights_of_a_table_are_kept():
    """Of each table but those that no digits can tell of; a check of a minute flies some of them."""
    made = {each.table for each in read_made()}
    assert made == KEPT.keys() | {*APART}
    for table, kept in read_digits().items():
        assert [each.flight for each in kept] == [*KEPT[table].flights]
    for table, each in KEPT.items():
        assert len(set(each.flights)) == 10, table
        assert 1 <= each.quick <= 10


def test_a_flight_moves_by_more_than_a_hundredth_of_its_bound():
    for change in ({"value": 1.0049}, {"value": 0.9951}, {"two_sigma": 0.5049}):
        assert moved([KNOWN], [replace(KNOWN, **change)]) == []
    for change in ({"value": 1.0051}, {"two_sigma": 0.4949}):
        assert moved([KNOWN], [replace(KNOWN, **change)])[0][0] == KNOWN
    assert moved([NOWHERE], [NOWHERE]) == []
    assert len(moved([KNOWN, NOWHERE], [NOWHERE, KNOWN])) == 2


@pytest.mark.parametrize("table", [n for n in ("study", "reference") if n in read_digits()])
def test_the_build_gives_the_digits_of_its_tables(table):
    (kept, *_) = read_digits()[table]
    assert moved([kept], digits_of(table, [kept.flight])) == []


def test_a_stale_table_is_listed_and_ends_with_one(monkeypatch, capsys):
    made = Made("study", "4", "0000000", "2026-11-29", "1", "study")
    value = [1.0]
    monkeypatch.setattr(module, "read_made", lambda: [made])
    monkeypatch.setattr(module, "read_digits", lambda: {"study": [KNOWN]})
    kept = Kept((KNOWN.flight,), lambda flight: (value[0], 0.5))
    monkeypatch.setitem(KEPT, "study", kept)
    assert stale() == ([], [])
    assert main(["stale"]) == 0
    value[0] = 1.1
    assert main(["stale"]) == 1
    said = capsys.readouterr().out
    assert "study (2026-11-29, 0000000, ? commits to the calibration): 1 of 1 flights moved" in said
    assert "20% of 2σ" in said
    monkeypatch.setattr(module, "read_digits", lambda: {})
    assert "keeps no digits" in stale()[0][0]
    monkeypatch.setattr(module, "read_made", lambda: [replace(made, table="speed")])
    assert main(["stale"]) == 0
    assert "speed (2026-11-29, 0000000, ? commits to the calibration): not judged by digits" in (
        capsys.readouterr().out
    )


@pytest.mark.skipif(not said_by_git("rev-parse", "HEAD"), reason="no checkout")
def test_the_commits_beside_are_those_of_the_calibration():
    """The paths are of the checkout, wherever git is called."""
    listed = said_by_git("ls-files", *module._JUDGED)
    assert "calibration/reduction.py" in listed
    assert "estimation/" in listed
