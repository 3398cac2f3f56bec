"""Make an aircraft flyable by the bench: copy it, explore it, shape its loops, write its autopilot. Done once."""

import os
import shutil
import xml.etree.ElementTree as ET
from contextlib import suppress
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp

from pitotbench.records.attached import ELECTRIC, Attached
from pitotbench.records.cache_folder import cache_folder
from pitotbench.records.errors import BadInputError
from pitotbench.simulate.aircraft_file import parse_xml
from pitotbench.simulate.attach.autopilot_file import write_autopilot, write_levers
from pitotbench.simulate.attach.derivatives import engine_time, linearize
from pitotbench.simulate.attach.envelope import explore
from pitotbench.simulate.attach.held import HeldAircraft
from pitotbench.simulate.attach.intake import aircraft_name, take_in
from pitotbench.simulate.attach.loops import shape
from pitotbench.simulate.attach.record import write_record
from pitotbench.simulate.fdm import SimulationError
from pitotbench.simulate.properties import CHANNELS
from pitotbench.units import DEGREE, FOOT, KNOT, POUND

ALTITUDE = 6000.0 * FOOT  # for which the loops are shaped: that of the cards
MOST_KEPT = 50  # attached aircraft in the cache
SURFACES = {"elevator": "elevator", "aileron": "left-aileron", "rudder": "rudder"}
ENGINE_KINDS = {
    "piston_engine": "piston",
    "turbine_engine": "jet",
    "turboprop_engine": "turboprop",
    "electric_engine": ELECTRIC,
    "brushless_dc_motor": ELECTRIC,
}


def attach(source: Path) -> Path:
    """Return the folder of an aircraft with the bench's autopilot; `source` is a JSBSim file or its folder.

    It is made the first time, which takes seconds, and kept in the cache under a digest of all files.
    Raises BadInputError for files that are not taken, SimulationError for an aircraft that cannot be flown.
    """
    if not source.exists():
        raise BadInputError(f"{source}: no such aircraft file or folder")
    source = source.resolve()
    main = source / f"{source.name}.xml"
    stamps = tuple(file.stat().st_mtime_ns for file in (source, main) if file.exists())
    return _attach(source, stamps)


@cache
def _attach(source: Path, stamps: tuple[int, ...]) -> Path:
    name = aircraft_name(source)
    with TemporaryDirectory(prefix="pitotbench-") as scratch:
        folder = Path(scratch) / name
        folder.mkdir()
        take_in(source, folder)
        place = _shelf() / f"{name}-{_digest(folder)}"
        if (place / name).is_dir():
            with suppress(OSError):
                os.utime(place)
            return place / name
        make_flyable(folder)
        return _keep(folder.parent, place) / name


def make_flyable(folder: Path) -> Attached:
    """Add the autopilot to the aircraft in a folder of its own, and write and return its record.

    Raises SimulationError, which says why, where the aircraft cannot be flown.
    """
    file = folder / f"{folder.name}.xml"
    tree = parse_xml(file)
    kind = _engine_kind(folder, tree.getroot())
    aircraft = _held(folder, kind)
    envelope = explore(aircraft)
    models = [linearize(aircraft, point) for point in envelope.points]
    lag = engine_time(aircraft, envelope.points[len(envelope.points) // 2])
    gains = shape(folder.name, models, lag)
    missing = _missing(aircraft)
    texts = "".join(f.read_text(encoding="utf-8") for f in sorted(folder.rglob("*.xml")))
    write_autopilot(folder / "Systems" / "attached-autopilot.xml", envelope, models, gains, aircraft.engines)
    write_levers(tree.getroot(), aircraft.engines, texts)
    tree.write(file, encoding="utf-8", xml_declaration=True)
    attached = Attached(
        aircraft=folder.name,
        altitude_ft=ALTITUDE / FOOT,
        mass_kg=round(aircraft.read("inertia/weight-lbs") * POUND, 2),
        stall_kt=round(envelope.stall / KNOT, 2),
        fastest_kt=round(envelope.fastest / KNOT, 2),
        mach_limited=envelope.limited,
        engines=aircraft.engines,
        engine_kind=kind,
        engine_time_s=lag,
        missing=missing,
        speed_kt=tuple(round(p.calibrated / KNOT, 2) for p in envelope.points),
        alpha_deg=tuple(round(p.alpha / DEGREE, 2) for p in envelope.points),
        lever=tuple(round(p.lever, 4) for p in envelope.points),
        pitch_rate=tuple(map(float, gains.pitch_rate)),
        bank=tuple(map(float, gains.bank)),
        climb=gains.climb,
        speed=gains.speed,
    )
    write_record(folder, attached)
    return attached


def _held(folder: Path, kind: str) -> HeldAircraft:
    import jsbsim

    try:
        return HeldAircraft(folder.name, folder, ALTITUDE, kind == ELECTRIC)
    except jsbsim.BaseError as error:  # such as a property that only another program defines
        raise SimulationError(f"{folder.name}: JSBSim stopped: {' '.join(str(error).split())}") from error


def _engine_kind(folder: Path, root: ET.Element) -> str:
    """Return the kind of the engines. Raises BadInputError for an aircraft without one that the bench can use."""
    tags = set()
    for element in root.iter("engine"):
        part = folder / "Engines" / f"{element.get('file')}.xml"
        inner = parse_xml(part).getroot() if part.is_file() else element
        tags |= {inner.tag} if part.is_file() else {child.tag for child in inner}
    kinds = {ENGINE_KINDS[tag] for tag in tags if tag in ENGINE_KINDS}
    if not kinds:
        what = ", ".join(sorted(tag for tag in tags if tag.endswith("engine"))) or "none"
        raise BadInputError(
            f"aircraft {folder.name}: no engine that holds a level speed (piston, turboprop, electric, jet); "
            f"it has {what}"
        )
    return " and ".join(sorted(kinds))


def _missing(aircraft: HeldAircraft) -> tuple[str, ...]:
    """Return the channels that an aircraft does not serve, or whose position does not follow its control."""
    still = [name for name, path in SURFACES.items() if not aircraft.moves(name, f"fcs/{path}-pos-rad")]
    return tuple(c.name for c in CHANNELS if c.name in still or not aircraft.serves(c.path))


def _shelf() -> Path:
    return cache_folder() / "aircraft"


def _digest(folder: Path) -> str:
    """Return the digest of an aircraft's files and of the code that attaches it."""
    here = Path(__file__).parent
    code = [*sorted(here.glob("*.*")), here.parent / "fdm.py", here.parent / "properties.py"]
    digest = sha256(repr([f"{name} {version(name)}" for name in ("jsbsim", "numpy", "scipy")]).encode())
    for root, files in ((here.parent, code), (folder, sorted(f for f in folder.rglob("*") if f.is_file()))):
        for file in files:
            digest.update(repr((file.relative_to(root).as_posix(), file.read_bytes())).encode())
    return digest.hexdigest()[:16]


def _keep(made: Path, place: Path) -> Path:
    """Move a finished aircraft to its place in the cache, completely or not at all; return where it is."""
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=place.parent, prefix=".") as scratch:
            copy = Path(shutil.copytree(made, Path(scratch) / "made"))
            with suppress(OSError):  # another process has just made the same
                copy.rename(place)
        if place.is_dir():
            _prune(place.parent)
            return place
    except OSError:  # a cache that cannot be written
        pass
    return Path(shutil.copytree(made, mkdtemp(prefix="pitotbench-"), dirs_exist_ok=True))


def _prune(shelf: Path) -> None:
    """Remove all but the aircraft used last."""
    kept = sorted((p for p in shelf.iterdir() if p.is_dir()), key=lambda p: p.stat().st_mtime, reverse=True)
    for old in kept[MOST_KEPT:]:
        shutil.rmtree(old, ignore_errors=True)
