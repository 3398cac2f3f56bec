"""Find aircraft and read their files: in the package, in the user's folder, at a path, in JSBSim's
library.
"""

import tomllib
import xml.etree.ElementTree as ET
from dataclasses import asdict
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import tomli_w

from pitotbench.catalog import UnknownNameError, explain
from pitotbench.effects.overlay import AeroFunction, Baseline, Engine, Point
from pitotbench.records import BadInputError
from pitotbench.records.aircraft import Attached
from pitotbench.units import FOOT


def parse_xml(file: Path, comments: bool = False) -> "ET.ElementTree[ET.Element]":
    """Parse an XML file of an aircraft and return its tree; `comments` keeps the XML comments.

    Raises BadInputError for a file that is not XML; the message names the file and the line.
    """
    try:
        return ET.parse(file, ET.XMLParser(target=ET.TreeBuilder(insert_comments=comments)))
    except ET.ParseError as error:
        raise BadInputError(f"aircraft file {file}: not valid XML: {error}") from error


_INCHES = {"IN": 1.0, "FT": 12.0, "M": 12.0 / FOOT}


def read_baseline(folder: Path) -> Baseline:
    """Read the baseline of the aircraft in a folder: center of gravity, aerodynamic functions,
    engines, settings.

    Raises BadInputError for a file that is not XML, or that holds text in place of a number.
    """
    root = parse_xml(folder / f"{folder.name}.xml").getroot()
    try:
        return Baseline(
            aircraft=folder.name,
            center_of_gravity=_point(root.find("mass_balance/location[@name='CG']")),
            functions=tuple(_functions(root)),
            engines=tuple(
                _engine(folder, element) for element in root.findall("propulsion/engine")
            ),
            declared=_declared(folder),
        )
    except BadInputError:
        raise
    except ValueError as error:
        raise BadInputError(f"aircraft {folder.name}: {error}") from error


def _functions(root: ET.Element) -> list[AeroFunction]:
    """Return the aerodynamic functions: those outside the axes, then those of each axis."""
    found = []
    for part in [*root.findall("aerodynamics"), *root.findall("aerodynamics/axis")]:
        for function in part.findall("function"):
            reads, looks_up = (
                frozenset((each.text or "").strip() for each in function.iter(tag))
                for tag in ("property", "independentVar")
            )
            numbers = any(value.text is not None for value in function.iter("value")) or bool(
                looks_up
            )
            found.append(
                AeroFunction(
                    part.get("name", ""), function.get("name", ""), reads, looks_up, numbers
                )
            )
    return found


def _engine(folder: Path, element: ET.Element) -> Engine:
    # An engine may stand in a file of its own or, in full, in the aircraft's file.
    file = folder / "Engines" / f"{element.get('file')}.xml"
    root = parse_xml(file).getroot() if file.is_file() else element
    fuel, friction = (float(root.findtext(tag) or 0.0) for tag in ("bsfc", "static-friction"))
    return Engine(_point(element.find("thruster/location")), fuel, friction)


def _declared(folder: Path) -> dict[str, float]:
    """Return the properties that any file of the folder declares with a value."""
    found = {}
    for file in sorted(folder.rglob("*.xml")):
        for element in parse_xml(file).getroot().iter("property"):
            value, path = element.get("value"), (element.text or "").strip()
            if value is not None and path:
                found[path] = float(value)
    return found


def _point(location: ET.Element | None) -> Point:
    if location is None:
        return (0.0, 0.0, 0.0)
    factor = _INCHES.get(location.get("unit", "IN"), 1.0)
    x, y, z = (float(location.findtext(axis) or 0.0) * factor for axis in "xyz")
    return (x, y, z)


# Find the aircraft and the parts that JSBSim's own package ships.

ENGINES, SYSTEMS = "engine", "systems"  # folders of parts that the aircraft share


@cache
def library() -> Path:
    """Return the folder of JSBSim's package, which holds `aircraft`, `engine` and `systems`."""
    spec = find_spec("jsbsim")  # located, not imported: that takes longer than the search
    places = list(spec.submodule_search_locations or ()) if spec else []
    return Path(places[0]).resolve() if places else Path()


@cache
def library_aircraft() -> dict[str, Path]:
    """Return JSBSim's own aircraft by name; each is the JSBSim file in its folder."""
    files = sorted((library() / "aircraft").glob("*/*.xml"))
    return {file.stem: file for file in files if file.stem == file.parent.name}


# Find aircraft: in the package or its checkout, in the user's folder, at a path, in JSBSim's own
# library.

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
    """Return the folder or file of an aircraft as its author wrote it, without the bench's
    autopilot.

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
    from pitotbench.simulation.autopilot.attach import (
        attach,
    )  # SciPy loads with it: only where it is needed

    return attach(source)


@cache
def has_autopilot(folder: Path) -> bool:
    """Return whether any file of an aircraft defines the targets of the bench's autopilot."""
    return any(b"ap/kcas-target-kt" in file.read_bytes() for file in folder.rglob("*.xml"))


def known_aircraft(places: tuple[Path, ...] | None = None) -> dict[str, Path]:
    """Return every aircraft by name. Where two folders hold one name, the first counts."""
    found: dict[str, Path] = {}
    for shelf in (*SHIPPED, OWN.resolve()) if places is None else places:
        for file in sorted(shelf.glob("*/*.xml")):
            if file.stem == file.parent.name:
                found.setdefault(file.stem, file.parent)
    return found


FILE = "attached.toml"


def write_record(folder: Path, attached: Attached) -> None:
    """Write the record into an aircraft's folder."""
    table = {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(attached).items()}
    (folder / FILE).write_text(tomli_w.dumps(table), encoding="utf-8")


@cache
def read_record(folder: Path) -> Attached | None:
    """Return the record in an aircraft's folder; None where the aircraft has an autopilot of its
    own. Raises BadInputError for a file that holds no such record.
    """
    from pydantic import TypeAdapter  # slow to load

    file = folder / FILE
    if not file.is_file():
        return None
    try:
        found = TypeAdapter(Attached).validate_python(tomllib.loads(file.read_text("utf-8")))
        if found.speed_kt:
            return found
    except ValueError:  # no text, no TOML, or a wrong field
        pass
    raise BadInputError(
        f"{file}: not the record of an attached autopilot; make this aircraft again from the "
        "author's files"
    )
