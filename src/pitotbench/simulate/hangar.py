"""Where aircraft are kept: in the installed package, the checkout it was installed from, the user's folder."""

from pathlib import Path

from pitotbench.catalog import UnknownNameError, explain

PACKAGE = Path(__file__).resolve().parents[1]
OWN = Path("aircraft")  # relative to where the bench runs: variants that the user keeps


def shelves() -> tuple[Path, ...]:
    """The folders in which aircraft are looked for, in order."""
    return (PACKAGE / "aircraft", PACKAGE.parents[1] / "aircraft", OWN.resolve())


def find_aircraft(name: str, places: tuple[Path, ...] | None = None) -> Path:
    """The folder of an aircraft, `<folder>/<name>.xml` being its JSBSim file.

    Looks in the package (the wheel ships its aircraft), in the checkout, then in `./aircraft`, where variants
    such as `navajo+pod` are written.
    Raises UnknownNameError with the known aircraft and the nearest where no shelf holds it.
    """
    known = known_aircraft(places)
    if name not in known:
        raise UnknownNameError(explain("aircraft", name, list(known)))
    return known[name]


def known_aircraft(places: tuple[Path, ...] | None = None) -> dict[str, Path]:
    """Every aircraft by name; where two shelves hold one name the first wins."""
    found: dict[str, Path] = {}
    for shelf in shelves() if places is None else places:
        for file in sorted(shelf.glob("*/*.xml")):
            if file.stem == file.parent.name:
                found.setdefault(file.stem, file.parent)
    return found
