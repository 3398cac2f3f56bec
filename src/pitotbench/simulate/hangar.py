"""Find aircraft: in the installed package, in the checkout it was installed from, in the user's folder."""

from pathlib import Path

from pitotbench.catalog import UnknownNameError, explain

PACKAGE = Path(__file__).resolve().parents[1]
OWN = Path("aircraft")  # relative to the working directory: the variants that the user keeps


def shelves() -> tuple[Path, ...]:
    """Return the folders in which aircraft are looked for, in order."""
    return (PACKAGE / "aircraft", PACKAGE.parents[1] / "aircraft", OWN.resolve())


def find_aircraft(name: str, places: tuple[Path, ...] | None = None) -> Path:
    """Return the folder of an aircraft; its JSBSim file is `<folder>/<name>.xml`.

    Looks in the package (the wheel ships its aircraft), in the checkout, then in `./aircraft`, where variants
    such as `navajo+pod` are written.
    Raises UnknownNameError where no folder holds it; the message lists the known aircraft and the nearest name.
    """
    known = known_aircraft(places)
    if name not in known:
        raise UnknownNameError(explain("aircraft", name, list(known)))
    return known[name]


def known_aircraft(places: tuple[Path, ...] | None = None) -> dict[str, Path]:
    """Return every aircraft by name. Where two folders hold one name, the first counts."""
    found: dict[str, Path] = {}
    for shelf in shelves() if places is None else places:
        for file in sorted(shelf.glob("*/*.xml")):
            if file.stem == file.parent.name:
                found.setdefault(file.stem, file.parent)
    return found
