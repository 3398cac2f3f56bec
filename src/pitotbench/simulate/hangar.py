"""Find aircraft: in the package or its checkout, in the user's folder, at a path, in JSBSim's own library."""

from functools import cache
from pathlib import Path

from pitotbench.catalog import UnknownNameError, explain
from pitotbench.simulate.attach.library import library_aircraft

PACKAGE = Path(__file__).resolve().parents[1]
OWN = Path("aircraft")  # relative to the working directory: the variants that the user keeps


def shelves() -> tuple[Path, ...]:
    """Return the folders in which aircraft are looked for, in order."""
    return (PACKAGE / "aircraft", PACKAGE.parents[1] / "aircraft", OWN.resolve())


def find_aircraft(name: str, places: tuple[Path, ...] | None = None) -> Path:
    """Return the folder of an aircraft; its JSBSim file is `<folder>/<name>.xml`.

    Looks in the package (the wheel ships its aircraft), in the checkout, then in `./aircraft`, where variants
    such as `navajo+pod` are written, then in JSBSim's own library. A name with a slash, or that ends in `.xml`, is
    the path of a JSBSim file or of its folder. Where an aircraft lacks the bench's autopilot, the folder is a copy
    with one attached.
    Raises UnknownNameError where no folder holds it; the message lists the known aircraft and the nearest name.
    Raises BadInputError or SimulationError for an aircraft that cannot be flown; the message says why.
    """
    if places is None and is_path(name):
        return _attached(Path(name))
    known = known_aircraft(places)
    if name in known:
        folder = known[name]
        return folder if places is not None or _has_autopilot(folder) else _attached(folder)
    if places is None and name in library_aircraft():
        return _attached(library_aircraft()[name].parent)
    lost = explain("aircraft", name, list(known))
    raise UnknownNameError(f"{lost}; or a path, or a name of JSBSim's library such as c172x")


def is_path(name: str) -> bool:
    """Return whether the name of an aircraft is the path of its file or folder."""
    return "/" in name or "\\" in name or name.endswith(".xml")


def _attached(source: Path) -> Path:
    from pitotbench.simulate.attach.attach import attach  # SciPy loads with it: only where it is needed

    return attach(source)


@cache
def _has_autopilot(folder: Path) -> bool:
    """Return whether any file of an aircraft defines the targets of the bench's autopilot."""
    return any(b"ap/kcas-target-kt" in file.read_bytes() for file in folder.rglob("*.xml"))


def known_aircraft(places: tuple[Path, ...] | None = None) -> dict[str, Path]:
    """Return every aircraft by name. Where two folders hold one name, the first counts."""
    found: dict[str, Path] = {}
    for shelf in shelves() if places is None else places:
        for file in sorted(shelf.glob("*/*.xml")):
            if file.stem == file.parent.name:
                found.setdefault(file.stem, file.parent)
    return found
