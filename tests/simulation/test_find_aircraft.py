"""The hangar: the package's aircraft first, then the checkout's."""

from pathlib import Path

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
