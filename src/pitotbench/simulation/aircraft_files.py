"""Read the folder of an aircraft (XML, autopilot's record, JSBSim model) and JSBSim's parts."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import asdict
from errno import ENOENT
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import tomli_w

from pitotbench.records import BadInputError
from pitotbench.records.aircraft import Attached
from pitotbench.records.intake import read_toml


def parse_xml(file: Path, comments: bool = False) -> "ET.ElementTree[ET.Element]":
    """Parse an XML file of an aircraft and return its tree; `comments` keeps the XML comments.

    Raises BadInputError for a file that is not XML; the message names the file and the line.
    """
    try:
        return ET.parse(file, ET.XMLParser(target=ET.TreeBuilder(insert_comments=comments)))
    except ET.ParseError as error:
        raise BadInputError(f"aircraft file {file}: not valid XML: {error}") from error


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


@cache
def has_autopilot(folder: Path) -> bool:
    """Return whether any file of an aircraft defines the targets of the bench's autopilot."""
    return any(b"ap/kcas-target-kt" in file.read_bytes() for file in folder.rglob("*.xml"))


FILE = "attached.toml"


def write_record(folder: Path, attached: Attached) -> None:
    """Write the record into an aircraft's folder."""
    table = {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(attached).items()}
    (folder / FILE).write_text(tomli_w.dumps(table), encoding="utf-8")


@cache
def read_record(folder: Path) -> Attached | None:
    """Return the record of the autopilot in an aircraft's folder, None for an autopilot of its own.

    Raises BadInputError for a file that holds no such record.
    """
    from pydantic import TypeAdapter  # slow to load

    file = folder / FILE
    if not file.is_file():
        return None
    try:
        found = TypeAdapter(Attached).validate_python(read_toml(file, "a record"))
        if found.speed_kt:
            return found
    except ValueError:  # no text, no TOML, or a wrong field
        pass
    raise BadInputError(
        f"{file}: not the record of an attached autopilot; make this aircraft again from the "
        "author's files"
    )


class SimulationError(BadInputError):
    """The case cannot be flown.

    The message says what happened, where in the flight, and what JSBSim reported.
    """


class Transcript:
    """Collect JSBSim's messages, which otherwise go to the console and not to the caller.

    JSBSim has one logger a thread. With several plants in a thread, the one loaded last gets the
    messages of all.
    """

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = []
        self._parts: list[str] = []
        self._level = 0

    # JSBSim calls the next five methods for each message: level, place, parts, colors, and the end.
    def set_level(self, level: Any) -> None:
        """Note the level of the message that begins."""
        self._level = int(level)

    def file_location(self, filename: str, line: int) -> None:
        """Add the file and the line of which the message speaks."""
        self._parts.append(f"{filename}:{line}: ")

    def message(self, message: str) -> None:
        """Add a part of the message."""
        self._parts.append(message)

    def format(self, format: Any) -> None:
        """Ignore colors, which mean nothing in an error message."""

    def flush(self) -> None:
        """End the message and keep it if it is a warning or an error."""
        import jsbsim

        text = " ".join("".join(self._parts).split())
        if text and int(jsbsim.LogLevel.WARN) <= self._level <= int(jsbsim.LogLevel.FATAL):
            self.lines.append(text)
        self._parts.clear()

    def said(self) -> str:
        """Return the last three messages as the end of an error message."""
        return f" JSBSim says: {' | '.join(self.lines[-3:])}" if self.lines else ""


def load_fdm(
    aircraft: str, folder: Path, rate: float, parts: tuple[Path, Path] | None = None
) -> tuple[Any, Transcript]:
    """Return an aircraft's JSBSim model, to run at a rate [Hz], with its transcript of messages.

    `folder` holds `<folder name>.xml`; `aircraft` names it in messages. `parts` are the folders of
    engines and systems, by default `Engines` and `Systems` in that folder. Raises SimulationError
    where JSBSim refuses a file, FileNotFoundError where a file was deleted meanwhile.
    """
    import jsbsim  # loads with the first aircraft, not with the table of maneuvers

    class Logger(Transcript, jsbsim.FGLogger):
        """The transcript as JSBSim calls it: its own class is known only now."""

    # The logger comes first: JSBSim reports errors of a file while it loads, and never again.
    transcript = Logger()
    jsbsim.set_logger(transcript)
    jsbsim.FGJSBBase().debug_lvl = 0  # type: ignore[no-untyped-call]
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_debug_level(0)
    fdm.set_dt(1.0 / rate)
    engines, systems = parts or (folder / "Engines", folder / "Systems")
    files = [folder / f"{folder.name}.xml", *folder.rglob("*.xml")]
    try:
        loaded = fdm.load_model_with_paths(
            folder.name, str(folder.parent), str(engines), str(systems)
        )
    except RuntimeError as error:  # what JSBSim throws for a file or a name that it cannot read
        loaded, words = False, " ".join(str(error).split())
        if words not in transcript.said():
            transcript.lines.append(words)
    if not loaded:
        if lost := [str(file) for file in files if not file.is_file()]:
            raise FileNotFoundError(ENOENT, "deleted while it was read", lost[0])
        raise SimulationError(f"JSBSim cannot load aircraft {aircraft!r}.{transcript.said()}")
    return fdm, transcript


LATITUDE = 35.4  # deg: Tullahoma, Tennessee, where the paper's aircraft flew


INTEGRATORS = tuple(
    f"simulation/integrator/{what}/{part}"
    for what in ("rate", "position")
    for part in ("translational", "rotational")
)
RUNNING = re.compile(r"propulsion/engine(\[\d+\])?/set-running")


def parse_catalog(lines: Iterable[str]) -> dict[str, str]:
    """Return JSBSim's property catalog, lines `path (RW)`, as a mapping from path to access."""
    pairs = (line.rsplit(" (", 1) for line in lines)
    return {path.strip(): access.rstrip(") ") for path, access in pairs}
