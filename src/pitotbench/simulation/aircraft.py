"""Find aircraft: in the package, in the user's folder, at a path, in JSBSim's library."""

from pathlib import Path

from pitotbench.catalog import UnknownNameError, explain
from pitotbench.simulation.aircraft_files import has_autopilot, library_aircraft

PACKAGE = Path(__file__).resolve().parents[1]
SHIPPED = (PACKAGE / "aircraft", PACKAGE.parents[1] / "aircraft")  # of the wheel, of the checkout
OWN = Path("aircraft")  # relative to the working directory: the variants that the user keeps


def find_aircraft(name: str, places: tuple[Path, ...] | None = None) -> Path:
    """Return the folder of an aircraft; its JSBSim file is `<folder>/<name>.xml`.

    Looks in the package (the wheel ships its aircraft), in the checkout, then in `./aircraft`,
    where variants such as `navajo+pod` are written, then in JSBSim's own library. A name with a
    slash, or that ends in `.xml`, is the path of a JSBSim file or of its folder. Only the files of
    the package and the checkout reach JSBSim as they are: of any other aircraft, or one that lacks
    the bench's autopilot, the folder is a cleaned copy that has one (`attach`). Raises
    UnknownNameError where no folder holds it; the message lists the known aircraft and the nearest
    name. Raises BadInputError or SimulationError for an aircraft that cannot be flown; the message
    says why.
    """
    if places is None and is_path(name):
        return _attached(Path(name))
    known = known_aircraft(places)
    if name in known:
        folder = known[name]
        ready = places is not None or (folder.parent in SHIPPED and has_autopilot(folder))
        return folder if ready else _attached(folder)
    if places is None and name in library_aircraft():
        return _attached(library_aircraft()[name].parent)
    lost = explain("aircraft", name, list(known))
    raise UnknownNameError(f"{lost}; or a path, or a name of JSBSim's library such as c172x")


def original(name: str) -> Path:
    """Return the folder or file of an aircraft as its author wrote it, without our autopilot.

    Parameters and errors are those of `find_aircraft`.
    """
    if is_path(name):
        return Path(name)
    known = {each: file.parent for each, file in library_aircraft().items()} | known_aircraft()
    if name not in known:
        raise UnknownNameError(explain("aircraft", name, list(known_aircraft())))
    return known[name]


def is_path(name: str) -> bool:
    """Return whether the name of an aircraft is the path of its file or folder."""
    return "/" in name or "\\" in name or name.endswith(".xml")


def _attached(source: Path) -> Path:
    # SciPy loads with it: only where it is needed.
    from pitotbench.simulation.autopilot.attach import attach

    return attach(source)


def known_aircraft(places: tuple[Path, ...] | None = None) -> dict[str, Path]:
    """Return every aircraft by name. Where two folders hold one name, the first counts."""
    found: dict[str, Path] = {}
    for shelf in (*SHIPPED, OWN.resolve()) if places is None else places:
        for file in sorted(shelf.glob("*/*.xml")):
            if file.stem == file.parent.name:
                found.setdefault(file.stem, file.parent)
    return found
