"""Copy an aircraft that others wrote into a folder of its own. Its files are input that is not trusted.

Only XML is taken, and only the files that the aircraft names: parsed, checked and written anew. A file name is
looked up in the aircraft's folder and among JSBSim's parts and cannot lead elsewhere. Elements that write files or
open network connections are left out.
"""

import re
import xml.etree.ElementTree as ET
from pathlib import Path

from pitotbench.records.errors import BadInputError
from pitotbench.simulate.attach.library import ENGINES, SYSTEMS, library

LARGEST_FILE = 4_000_000  # bytes; the largest file of JSBSim's library has 0.5 MB
MOST_FILES = 100
DEEPEST = 60  # elements within one another; JSBSim parses them by recursion
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+ -]*")
# Root elements through which JSBSim writes files or opens sockets.
CLOSED = ("output", "input")
PARTS = {
    "engine": ("Engines", ENGINES),
    "thruster": ("Engines", ENGINES),
    "system": ("Systems", SYSTEMS),
    "autopilot": (".", SYSTEMS),  # JSBSim looks for these two in the aircraft's folder only
    "flight_control": (".", SYSTEMS),
}
WHOLE = (
    *("metrics", "mass_balance", "ground_reactions", "propulsion", "aerodynamics", "external_reactions"),
    *("buoyant_forces", "fileheader"),
)


def take_in(file: Path, folder: Path) -> Path:
    """Copy the aircraft of a JSBSim file, with all parts that it names, into a new folder; return the new file.

    Raises BadInputError for a file that is no JSBSim aircraft, is too large, declares entities, or names a part
    outside its own folder and JSBSim's library.
    """
    if file.is_dir():
        file = _main_file(file)
    taking = _Taking(file.resolve().parent)
    root = taking.read(file.resolve())
    if root.tag != "fdm_config":
        raise BadInputError(f"{file.name}: not an aircraft of JSBSim: its root is <{_short(root.tag)}>")
    for part in (folder / "Engines", folder / "Systems"):
        part.mkdir(parents=True)
    taking.parts_of(root, folder)
    copy = folder / f"{folder.name}.xml"
    _write(root, copy)
    return copy


def aircraft_name(path: Path) -> str:
    """Return the name of the aircraft at a path: that of the file, with all signs but letters and digits as `_`."""
    name = re.sub(r"[^A-Za-z0-9-]+", "_", path.stem if path.suffix == ".xml" else path.name)
    return name.strip("_")[:60] or "aircraft"


def _main_file(folder: Path) -> Path:
    same = folder / f"{folder.resolve().name}.xml"
    files = [same] if same.is_file() else sorted(folder.glob("*.xml"))
    if len(files) != 1:
        raise BadInputError(
            f"{folder}: {len(files)} XML files and none named {same.name}: name the file of the aircraft"
        )
    return files[0]


class _Taking:
    """One intake: the files read so far, and where parts are looked for."""

    def __init__(self, home: Path) -> None:
        self._home = home
        self._count = 0

    def read(self, file: Path) -> ET.Element:
        """Return the root of a file. Raises BadInputError for one that must not reach JSBSim."""
        self._count += 1
        if self._count > MOST_FILES:
            raise BadInputError(f"the aircraft names more than {MOST_FILES} files")
        if not file.is_file():
            raise BadInputError(f"{file}: no such file")
        if file.stat().st_size > LARGEST_FILE:
            raise BadInputError(f"{file.name}: larger than {LARGEST_FILE // 1_000_000} MB")
        parser = ET.XMLParser(target=_Builder(file.name, trusted=file.is_relative_to(library())))
        try:
            parser.feed(file.read_bytes())
            root: ET.Element = parser.close()
        except BadInputError:
            raise
        except (ET.ParseError, ValueError, LookupError) as error:
            raise BadInputError(f"aircraft file {file.name}: not valid XML: {error}") from error
        root.attrib = {key: value for key, value in root.attrib.items() if not key.startswith("{")}
        return root

    def parts_of(self, root: ET.Element, folder: Path) -> None:
        """Copy the parts that an aircraft names, and close the elements that reach outside the simulation."""
        for element in [e for e in root if e.tag in CLOSED]:
            root.remove(element)
        self._parts(root, folder, [])

    def _parts(self, root: ET.Element, folder: Path, above: list[str]) -> None:
        for element in list(root.iter()):
            name = element.get("file")
            if name is None or (element is root and above):
                continue
            if element.tag in WHOLE:
                self._insert(element, name)
                self._parts(element, folder, above)
            elif element.tag in PARTS:
                self._part(element, name, folder, above)

    def _insert(self, element: ET.Element, name: str) -> None:
        """Replace an element that names a file of the aircraft's folder by the content of that file."""
        inner = self.read(self._find(name, (self._home,)))
        del element.attrib["file"]
        element.attrib.update(inner.attrib)
        element.extend(inner)

    def _part(self, element: ET.Element, name: str, folder: Path, above: list[str]) -> None:
        own, shared = PARTS[element.tag]
        places = (self._home, self._home / own, self._home / own.lower(), library() / shared)
        stem = name.strip().removesuffix(".xml")
        copy = folder / own / f"{re.sub(r'[^A-Za-z0-9_.+-]', '_', stem)}.xml"
        element.set("file", copy.stem)
        if stem in above:
            raise BadInputError(f"{stem}.xml names itself")
        if copy.exists():
            return
        inner = self.read(self._find(name, places))
        self._parts(inner, folder, [*above, stem])
        _write(inner, copy)

    def _find(self, name: str, places: tuple[Path, ...]) -> Path:
        name = name.strip()
        if not NAME.fullmatch(name) or ".." in name:
            raise BadInputError(
                f"the aircraft names the file {_short(name)!r}: a plain file name is allowed, no path"
            )
        name = name if name.endswith(".xml") else f"{name}.xml"
        for place in places:
            file = (place / name).resolve()
            # A link must not lead out of the folder.
            if file.is_file() and file.is_relative_to(place.resolve()):
                return file
        raise BadInputError(f"the aircraft names {name}, which is neither in its folder nor among JSBSim's parts")


class _Builder(ET.TreeBuilder):
    """Build a tree and refuse what may grow without limit."""

    def __init__(self, name: str, trusted: bool) -> None:
        super().__init__()
        self._name = name
        self._trusted = trusted
        self._depth = 0

    def doctype(self, *_: object) -> None:
        """Refuse a document type: it may declare entities, which read other files or grow without limit."""
        if not self._trusted:  # JSBSim's own parts declare some
            raise BadInputError(f"{self._name}: a DOCTYPE is not allowed; delete it")

    def start(self, tag: str, attrs: dict[str, str]) -> ET.Element:
        """Begin an element."""
        self._depth += 1
        if self._depth > DEEPEST:
            raise BadInputError(f"{self._name}: elements are nested more than {DEEPEST} deep")
        return super().start(tag, attrs)

    def end(self, tag: str) -> ET.Element:
        """End an element."""
        self._depth -= 1
        return super().end(tag)


def _write(root: ET.Element, file: Path) -> None:
    ET.ElementTree(root).write(file, encoding="utf-8", xml_declaration=True)


def _short(text: str) -> str:
    return text if len(text) <= 60 else text[:57] + "..."
