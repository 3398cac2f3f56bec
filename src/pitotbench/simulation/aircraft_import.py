"""Copy an aircraft that others wrote into a folder of its own.

Its files are input that is not trusted. Only XML is taken, and only the files that the aircraft
names: parsed, checked and written anew. A file name is looked up in the aircraft's folder and among
JSBSim's parts and cannot lead elsewhere, but for `../Engines` and the like. Of the root only what
describes an airplane is taken: other elements write files, open sockets or load a second airplane
unread. Properties that command the simulator are refused.
"""

import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path

import numpy as np

from pitotbench.records import BadInputError
from pitotbench.simulation.aircraft_files import (
    ENGINES,
    SYSTEMS,
    SimulationError,
    library,
    load_fdm,
    parse_xml,
)
from pitotbench.simulation.autopilot.frozen_aircraft import RATE
from pitotbench.units import DEGREE, Array

LARGEST_FILE = 4_000_000  # bytes; the largest file of JSBSim's library has 0.5 MB
MOST_FILES = 100  # of an airplane, with its engines and systems
MOST_ELEMENTS = 20_000  # of all its files; JSBSim's largest airplane has 4,500
DEEPEST = 60  # elements within one another; JSBSim parses them by recursion
# s or frames, that a part of a control law waits; JSBSim keeps a number for each frame of it.
LONGEST_DELAY = 1000.0
LONGEST_TRIAL = 120.0  # s, in which JSBSim loads the aircraft and takes its first steps
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+ -]*")
SIBLINGS = ("engine", "engines", "systems")  # folders of parts next to that of the aircraft
# Elements below a root through which JSBSim writes files, opens sockets or loads further airplanes.
CLOSED = ("output", "input", "child")
COMMANDS = re.compile(r"write-state-file|jsbsim-debug|simulation.*(reset|trim)", re.IGNORECASE)
PARTS = {
    "engine": ("Engines", ENGINES),
    "thruster": ("Engines", ENGINES),
    "system": ("Systems", SYSTEMS),
    "autopilot": (".", SYSTEMS),  # JSBSim looks for these two in the aircraft's folder only
    "flight_control": (".", SYSTEMS),
}
WHOLE = (
    *(
        "metrics",
        "mass_balance",
        "ground_reactions",
        "propulsion",
        "aerodynamics",
        "external_reactions",
    ),
    *("buoyant_forces", "fileheader"),
)


def import_aircraft(file: Path, folder: Path) -> Path:
    """Copy a JSBSim file's aircraft, with all parts it names, into a new folder; return the file.

    Raises BadInputError for a file that is no JSBSim aircraft, is too large, declares entities, or
    names a part outside its own folder and JSBSim's library.
    """
    if file.is_dir():
        same = file / f"{file.resolve().name}.xml"
        files = [same] if same.is_file() else sorted(file.glob("*.xml"))
        if len(files) != 1:
            raise BadInputError(
                f"{file}: {len(files)} XML files and none named {same.name}: name the file of the "
                "aircraft"
            )
        file = files[0]
    importing = _Import(file.resolve().parent)
    root = importing.read(file.resolve())
    if root.tag != "fdm_config":
        raise BadInputError(f"{file.name}: not an aircraft of JSBSim: its root is <{root.tag:.60}>")
    for part in (folder / "Engines", folder / "Systems"):
        part.mkdir(parents=True)
    for element in [e for e in root if e.tag not in (*WHOLE, *PARTS)]:
        root.remove(element)
    importing.parts(root, folder)
    copy = folder / f"{folder.name}.xml"
    _write(root, copy)
    if file.resolve().is_relative_to(library()):
        with suppress(SimulationError):  # what JSBSim cannot load is refused where it is flown
            _declare_missing(root, copy)
    else:
        _try_in_child(copy)
    return copy


def try_aircraft(copy: Path) -> None:
    """Declare what a copied aircraft reads and nothing creates, load it, and take two steps."""
    with suppress(SimulationError, RuntimeError):  # what cannot be flown is refused where it is
        _declare_missing(parse_xml(copy).getroot(), copy)
        fdm, _ = load_fdm(copy.stem, copy.parent, RATE)
        fdm.run_ic()
        fdm.run()


def _try_in_child(copy: Path) -> None:
    """Try an aircraft in a process of its own.

    JSBSim ends a process whose functions read themselves, by their recursion. Raises BadInputError
    where it does, or takes too long.
    """
    code = f"import sys, pathlib; from {__name__} import try_aircraft as a; a(pathlib.Path(sys.argv[1]))"
    paths = [str(Path(__file__).parents[2]), *filter(None, [os.environ.get("PYTHONPATH")])]
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-c", code, str(copy)],
            env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=LONGEST_TRIAL,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise BadInputError(
            f"{copy.name}: JSBSim does not load it in {LONGEST_TRIAL:.0f} s; fly a smaller model"
        ) from error
    if done.returncode < 0:
        raise BadInputError(
            f"{copy.name}: JSBSim breaks down in its first step; look for a function that reads "
            "itself, or two that read each other"
        )
    if done.returncode:
        *_, words = ["it cannot be loaded", *done.stderr.decode(errors="replace").splitlines()]
        raise BadInputError(f"{copy.name}: {words[:300]}")


# A model made for FlightGear reads properties that FlightGear writes, such as those of switches.
# JSBSim alone stops at the first.
PATH = re.compile(r"-?(/?[A-Za-z_][\w.:-]*(\[\d+\])?(/[A-Za-z_][\w.:-]*(\[\d+\])?)+(?<!\.))")
PROSE = ("fileheader", "documentation", "description")
ZEROS = "set-to-zero"  # the system that declares them
# Branches that hold the state of flight: there a missing name is a slip of the pen, and with 0 in
# its place another airplane would fly.
STATE = ("accelerations", "aero", "atmosphere", "attitude", "inertia", "metrics", "velocities")


def _declare_missing(root: ET.Element, file: Path) -> None:
    """Declare as 0 what the files of a copied aircraft read and nothing creates."""
    fdm, _ = load_fdm(file.parent.name, file.parent, RATE)
    tree = fdm.get_property_manager()
    read = {path for f in file.parent.rglob("*.xml") for path in _paths(parse_xml(f).getroot())}
    missing = [p for p in read if p.split("/")[0] not in STATE and not tree.hasNode(p)]
    if missing:
        system = ET.SubElement(root, "system", name=ZEROS)
        for path in sorted(missing):
            ET.SubElement(system, "property", value="0").text = path
        _write(root, file)


def _paths(element: ET.Element) -> Iterator[str]:
    """Yield what an element and those within it hold that reads as the path of a property."""
    for word in f"{element.text or ''} {element.get('value', '')}".split():
        if found := PATH.fullmatch(word):
            yield found[1]
    for child in element:
        if child.tag not in PROSE:
            yield from _paths(child)


def set_to_zero(folder: Path) -> tuple[str, ...]:
    """Return the properties that an aircraft reads and nothing creates: 0 in its copy."""
    root = parse_xml(folder / f"{folder.name}.xml").getroot()
    return tuple(e.text or "" for e in root.iterfind(f"system[@name='{ZEROS}']/property"))


ANGLES = {"aero/alpha-rad": 1.0, "aero/alpha-deg": DEGREE}
RATE_OF = re.compile("velocities/[pqr]|alphadot")


def left_tables(root: ET.Element, alphas: Sequence[float]) -> list[str]:
    """Return a sentence for each table of lift or drag that level flight leaves by more than 1°.

    `alphas` are the angles of attack [rad] of level flight. JSBSim keeps the value of the last row
    beyond the end of a table. An end where the table is 0 or level counts as meant. Tables of
    damping are left out.
    """
    axes = [a for a in root.iterfind("aerodynamics/axis") if a.get("name") in ("LIFT", "DRAG")]
    read = {(each.text or "").strip() for axis in axes for each in axis.iter("property")}
    functions = [f for f in root.iterfind("aerodynamics/function") if f.get("name") in read]
    functions += [f for axis in axes for f in axis.iterfind("function")]
    found = []
    for function in functions:
        if any(RATE_OF.search(each.text or "") for each in function.iter("property")):
            continue
        with suppress(ValueError, IndexError):  # no table as JSBSim's manual has it
            for rows in chain.from_iterable(map(_rows_by_angle, function.iter("table"))):
                for end, inner, flown in ((0, 1, min(alphas)), (-1, -2, max(alphas))):
                    (last, *values), (before, *others) = rows[end].tolist(), rows[inner].tolist()
                    over = (flown - last) * np.sign(last - before)
                    if over > DEGREE and any(values) and values != others:
                        found.append(
                            f"level flight reaches {flown / DEGREE:.1f}° of angle of attack, where "
                            f"{function.get('name')} has no row: it ends at {last / DEGREE:.1f}°"
                        )
    return list(dict.fromkeys(found))


def _rows_by_angle(table: ET.Element) -> Iterator[Array]:
    """Yield the rows of a table by angle of attack: the angle [rad], then values."""
    axes = [(v.get("lookup", "row"), (v.text or "").strip()) for v in table.iter("independentVar")]
    for data in table.iter("tableData"):
        text = data.text or ""
        # The first line of a table of two variables names the columns. That of one has one column.
        head = "0" if len(axes) == 1 else ""
        width = 1 + len((head or text.strip()).splitlines()[0].split())
        block = np.array(f"nan {head} {text}".split(), dtype=float).reshape(-1, width)
        for lookup, angle in axes:
            rows = {"row": block, "column": block.T}.get(lookup, block[:0])[1:]
            if angle in ANGLES and len(rows) > 1:
                yield np.column_stack([rows[:, 0] * ANGLES[angle], rows[:, 1:]])


def aircraft_name(path: Path) -> str:
    """Return the name of the aircraft at a path, that of the file with `_` for odd characters.

    Odd are those that the name of a variant cannot hold.
    """
    name = re.sub(r"[^A-Za-z0-9.+-]+", "_", path.stem if path.suffix == ".xml" else path.name)
    return name.strip("_.")[:60] or "aircraft"


class _Import:
    """One intake: the files read so far, and where parts are looked for."""

    def __init__(self, home: Path) -> None:
        self._home = home
        self._count = self._elements = 0

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
        self._elements += sum(1 for _ in root.iter())
        if self._elements > MOST_ELEMENTS:
            raise BadInputError(
                f"the aircraft's files hold more than {MOST_ELEMENTS:,} elements, which JSBSim "
                "takes minutes to load; fly a smaller model"
            )
        root.attrib = {key: value for key, value in root.attrib.items() if not key.startswith("{")}
        _require_no_command(file.name, root)
        _require_short_delays(file.name, root)
        return root

    def parts(self, root: ET.Element, folder: Path, above: tuple[str, ...] = ()) -> None:
        """Copy the parts that an element names; `above` are the files that name it."""
        for element in list(root.iter()):
            name = element.get("file")
            if name is None or (element is root and above):
                continue
            if element.tag in WHOLE:  # it becomes the content of a file of the aircraft's folder
                inner = self.read(self._find(name, (self._home,)))
                del element.attrib["file"]
                element.attrib.update(inner.attrib)
                element.extend(inner)
                self.parts(element, folder, above)
            elif element.tag in PARTS:
                self._part(element, name, folder, above)

    def _part(self, element: ET.Element, name: str, folder: Path, above: tuple[str, ...]) -> None:
        own, shared = PARTS[element.tag]
        places = (self._home, self._home / own, self._home / own.lower(), library() / shared)
        stem = name.strip().removesuffix(".xml")
        copy = folder / own / f"{re.sub(r'[^A-Za-z0-9_.+-]', '_', stem.lstrip('./'))}.xml"
        element.set("file", copy.stem)
        if stem in above:
            raise BadInputError(f"{stem}.xml names itself")
        if copy.exists():
            return
        inner = self.read(self._find(name, places))
        for closed in [e for e in inner if e.tag in CLOSED]:
            inner.remove(closed)
        self.parts(inner, folder, (*above, stem))
        _write(inner, copy)

    def _find(self, name: str, places: tuple[Path, ...]) -> Path:
        *folders, plain = name.strip().removesuffix(".xml").split("/")
        sibling = folders[:1] == [".."] and folders[-1].lower() in SIBLINGS and len(folders) == 2
        inner = "/".join(folders[sibling:])
        if not all(NAME.fullmatch(p) and ".." not in p for p in [*folders[sibling:], plain]):
            raise BadInputError(
                f"the aircraft names the file {name[:60]!r}: a plain file name is allowed, or one "
                "in a folder of the aircraft's"
            )
        sought = [place / inner for place in (*places, *[self._home.parent] * sibling)]
        name = f"{plain}.xml"
        for place in (*sought, *places):
            file = (place / name).resolve()
            # A link must not lead out of the folder.
            if file.is_file() and file.is_relative_to(place.resolve()):
                return file
        raise BadInputError(
            f"the aircraft names {name}, which is neither in its folder nor among JSBSim's parts"
        )


def _require_no_command(name: str, root: ET.Element) -> None:
    """Raise BadInputError for a property by which an airplane would command the simulator.

    Commands write its state into files, begin anew, trim, or print.
    """
    # Each word is checked: JSBSim takes a line of several, and what follows an element within.
    texts = (text for e in root.iter() for text in (e.text, e.tail, *e.attrib.values()) if text)
    for word in (word for text in texts for word in text.split()):
        if COMMANDS.search(word):
            raise BadInputError(
                f"{name}: the property {word[:60]!r} commands the simulator; take it out of the "
                "aircraft's file"
            )


def _require_short_delays(name: str, root: ET.Element) -> None:
    """Raise BadInputError for a delay by which JSBSim would end the program.

    Such a delay fills the memory, or is no number.
    """
    for delay in root.iter("delay"):
        with suppress(ValueError):
            if 0.0 <= float(delay.text or "") <= LONGEST_DELAY:
                continue
        raise BadInputError(
            f"{name}: a delay of {(delay.text or '').strip()[:60]!r}: a number from 0 to "
            f"{LONGEST_DELAY:g} is allowed"
        )


class _Builder(ET.TreeBuilder):
    """Build a tree and refuse what may grow without limit."""

    def __init__(self, name: str, trusted: bool) -> None:
        super().__init__()
        self._name = name
        self._trusted = trusted
        self._depth = 0

    def doctype(self, *_: object) -> None:
        """Refuse a document type, whose entities may read other files or grow without limit."""
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
