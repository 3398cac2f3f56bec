"""Read the baseline of an aircraft: center of gravity, aerodynamic functions, engines."""

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from pathlib import Path

from pitotbench.effects.overlay import AeroFunction, Baseline, Dimension, Engine, Point
from pitotbench.records import BadInputError
from pitotbench.simulation.aircraft_files import parse_xml
from pitotbench.units import FOOT, POUND

_INCHES = {"IN": 1.0, "FT": 12.0, "M": 12.0 / FOOT}


def read_baseline(folder: Path) -> Baseline:
    """Read the center of gravity, aerodynamic functions, engines and settings of an aircraft.

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
            dimensions=dict(_dimensions(root)),
        )
    except BadInputError:
        raise
    except ValueError as error:
        raise BadInputError(f"aircraft {folder.name}: {error}") from error


# where the file of an aircraft tells a dimension, and the unit of a number without one
_IN_FILE: Mapping[Dimension, tuple[str, str]] = {
    "empty mass": ("mass_balance/emptywt", "LBS"),
    "wing area": ("metrics/wingarea", "FT2"),
    "chord": ("metrics/chord", "FT"),
}
_UNITS = {
    "LBS": POUND,
    "KG": 1.0,
    "FT": FOOT,
    "M": 1.0,
    "IN": FOOT / 12.0,
    "FT2": FOOT**2,
    "M2": 1.0,
}


def _dimensions(root: ET.Element) -> Iterator[tuple[Dimension, float]]:
    """The dimensions that the file of an airplane tells in a unit that is known, in SI units."""
    for name, (path, usual) in _IN_FILE.items():
        for element in root.findall(path)[:1]:
            value = float(element.text or 0.0) * _UNITS.get(element.get("unit", usual), 0.0)
            if value > 0.0:
                yield name, value


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
