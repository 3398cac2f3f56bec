"""The hangar: the package's aircraft first, then the checkout's."""

from pathlib import Path

import pytest

from pitotbench.catalog import UnknownNameError
from pitotbench.simulation.aircraft import find_aircraft, known_aircraft


def shelf(root: Path, *names: str) -> Path:
    for name in names:
        (root / name).mkdir(parents=True)
        (root / name / f"{name}.xml").touch()
    return root


def test_the_first_shelf_wins_and_both_are_known(tmp_path):
    wheel, checkout = shelf(tmp_path / "wheel", "navajo"), shelf(tmp_path / "checkout", "navajo", "other")
    (checkout / "empty").mkdir()
    assert find_aircraft("navajo", (wheel, checkout)) == wheel / "navajo"
    assert find_aircraft("other", (wheel, checkout)) == checkout / "other"
    assert set(known_aircraft((wheel, checkout))) == {"navajo", "other"}


def test_an_unknown_aircraft_names_the_nearest(tmp_path):
    with pytest.raises(UnknownNameError, match=r"Did you mean 'navajo'\? Known: navajo"):
        find_aircraft("navaho", (shelf(tmp_path, "navajo"), tmp_path / "nowhere"))


def test_the_benchs_own_aircraft_is_found():
    assert (find_aircraft("navajo") / "navajo.xml").is_file()
