"""Where aircraft are kept: in the installed package, else in the checkout it was installed from."""

from pathlib import Path

from pitotbench.catalog import UnknownNameError, explain

PACKAGE = Path(__file__).resolve().parents[1]
SHELVES = (PACKAGE / "aircraft", PACKAGE.parents[1] / "aircraft")


def find_aircraft(name: str, shelves: tuple[Path, ...] = SHELVES) -> Path:
    """The folder of an aircraft, `<folder>/<name>.xml` being its JSBSim file.

    Looks in the package (the wheel ships its aircraft), then in the checkout.
    Raises UnknownNameError with the known aircraft and the nearest where no shelf holds it.
    """
    known = known_aircraft(shelves)
    if name not in known:
        raise UnknownNameError(explain("aircraft", name, list(known)))
    return known[name]


def known_aircraft(shelves: tuple[Path, ...] = SHELVES) -> dict[str, Path]:
    """Every aircraft by name; where two shelves hold one name the first wins."""
    found: dict[str, Path] = {}
    for shelf in shelves:
        for file in sorted(shelf.glob("*/*.xml")):
            if file.stem == file.parent.name:
                found.setdefault(file.stem, file.parent)
    return found
