"""The differences of two files of an airplane, part by part."""

import shutil
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from pitotbench.simulation.aircraft_files import parse_xml
from pitotbench.simulation.aircraft_import import PROSE

Key = tuple[str, ...]
METRICS = {"wingarea": "wing area", "wingspan": "wing span", "chord": "mean chord"}


@dataclass(frozen=True, slots=True)
class Edit:
    """A difference between two files of an aircraft.

    The part's key, its element or file in the old and in the new one (None: it has none).

    `place` is that of the part in its section of the new file.
    """

    key: Key
    old: ET.Element | Path | None
    new: ET.Element | Path | None
    place: int = 0

    @property
    def part(self) -> str:
        """The part in the file's words."""
        kind, *names = self.key
        if kind == "metrics" and names[-1] in METRICS:
            return METRICS[names[-1]]
        named = " ".join(name for name in names if name)
        change = (
            ""
            if self.old is not None and self.new is not None
            else " (added)"
            if self.old is None
            else " (gone)"
        )
        return (
            named if kind == "aerodynamics" and len(names) == 2 else f"{kind}: {named}"
        ) + change


def edits_between(old: Path, new: Path) -> list[Edit]:
    """Return the differences between the files of two folders, part by part."""
    roots = [parse_xml(f / f"{f.name}.xml").getroot() for f in (old, new)]
    parts = [dict(_parts(root)) for root in roots]
    places = {id(child): i for section in roots[1].iter() for i, child in enumerate(section)}
    files = [
        {("file", p.relative_to(f).as_posix()): p for p in f.glob("*/*.xml")} for f in (old, new)
    ]
    found = []
    for before, after in (parts, files):
        for key in dict.fromkeys((*before, *after)):
            a, b = before.get(key), after.get(key)
            if a is None or b is None or content(a) != content(b):
                found.append(Edit(key, a, b, places.get(id(b), 0)))
    return found


def _parts(root: ET.Element) -> Iterator[tuple[Key, ET.Element]]:
    """Yield the parts of an aircraft's file with their keys.

    A part is each function of the aerodynamics, and elsewhere each child.
    """
    for section, head in _sections(root):
        seen: dict[Key, int] = {}
        for child in section:
            if child.tag in PROSE or child.tag == "axis":
                continue
            name = child.get("name") or child.get("file") or ""
            key = (*head, name if child.tag == "function" else f"{child.tag} {name}".strip())
            number = seen[key] = seen.get(key, 0) + 1
            yield (key if number == 1 else (*key[:-1], f"{key[-1]} {number}")), child


def _sections(root: ET.Element) -> Iterator[tuple[ET.Element, Key]]:
    for section in root:
        if section.tag in PROSE:
            continue
        name = "" if section.tag == "aerodynamics" else section.get("name", section.get("file", ""))
        yield section, (section.tag, name)
        if section.tag == "aerodynamics":
            yield from (
                (axis, (section.tag, axis.get("name", ""))) for axis in section.findall("axis")
            )


def content(part: ET.Element | Path) -> object:
    """Return all that JSBSim reads of a part, numbers by value, without comments and spaces."""
    element = parse_xml(part).getroot() if isinstance(part, Path) else part
    return (
        element.tag,
        sorted(element.attrib.items()),
        [token(t) for t in (element.text or "").split()],
        [content(child) for child in element if child.tag not in PROSE],
    )


def token(text: str) -> float | str:
    """Return the number that a text states, else the text."""
    try:
        return float(text)
    except ValueError:
        return text


def apply_edits(root: ET.Element, edits: Sequence[Edit], folder: Path) -> None:
    """Put differences into the file, and into the files of parts, of an aircraft."""
    for edit in edits:
        if isinstance(edit.new, Path):
            target = folder / edit.key[1]
            target.parent.mkdir(exist_ok=True)
            shutil.copyfile(edit.new, target)
            continue
        if isinstance(edit.old, Path):
            continue  # a file that nothing names any more does nothing
        sections = {head: section for section, head in _sections(root)}
        section = sections.get(edit.key[:2])
        if section is None:
            above = (
                root if edit.key[0] != "aerodynamics" else sections.get(("aerodynamics", ""), root)
            )
            tag = "axis" if edit.key[0] == "aerodynamics" else edit.key[0]
            section = ET.SubElement(above, tag, name=edit.key[1])
        children = list(section)
        place = dict(_parts(root)).get(edit.key)
        at = children.index(place) if place is not None else min(edit.place, len(children))
        if place is not None:
            section.remove(place)
        if edit.new is not None:
            section.insert(at, edit.new)
