"""Make an aircraft flyable by the bench: copy it, explore it, shape its loops, write its autopilot. Done once."""

import os
import shutil
import xml.etree.ElementTree as ET
from contextlib import suppress
from dataclasses import replace
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp

from pitotbench.records.attached import ELECTRIC, TURBOPROP, Attached
from pitotbench.records.cache_folder import cache_folder
from pitotbench.records.errors import BadInputError
from pitotbench.simulate.aircraft_file import parse_xml
from pitotbench.simulate.attach.autopilot_file import open_all_tanks, write_autopilot, write_levers
from pitotbench.simulate.attach.derivatives import Linear, engine_time, linearize
from pitotbench.simulate.attach.envelope import Envelope, explore
from pitotbench.simulate.attach.held import Engines, HeldAircraft
from pitotbench.simulate.attach.intake import aircraft_name, take_in
from pitotbench.simulate.attach.loops import Gains, shape
from pitotbench.simulate.attach.record import write_record
from pitotbench.simulate.fdm import SimulationError
from pitotbench.simulate.properties import CHANNELS
from pitotbench.units import DEGREE, FOOT, KNOT, POUND

Shaped = tuple[Envelope, list[Linear], Gains]
ALTITUDE = 6000.0 * FOOT  # for which the loops are shaped: that of the cards
MOST_KEPT = 50  # attached aircraft in the cache
SURFACES = {"elevator": "elevator", "aileron": "left-aileron", "rudder": "rudder"}
ENGINE_KINDS = {
    "piston_engine": "piston",
    "turbine_engine": "jet",
    "turboprop_engine": TURBOPROP,
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
    return _attach(source, stamps, _shelf())


@cache
def _attach(source: Path, stamps: tuple[int, ...], shelf: Path) -> Path:
    name = aircraft_name(source)
    with TemporaryDirectory(prefix="pitotbench-") as scratch:
        folder = Path(scratch) / name
        folder.mkdir()
        take_in(source, folder)
        place = shelf / f"{name}-{_digest(folder)}"
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
    kind = _engines(folder, tree.getroot())
    aircraft = _held(folder, kind)
    envelope = explore(aircraft)
    lag = engine_time(aircraft, envelope.points[len(envelope.points) // 2])
    models = [linearize(aircraft, point) for point in envelope.points]
    envelope, models, gains = _shaped(folder.name, envelope, models, lag)
    missing = _missing(aircraft)
    texts = "".join(f.read_text(encoding="utf-8") for f in sorted(folder.rglob("*.xml")))
    write_autopilot(folder / "Systems" / "attached-autopilot.xml", envelope, models, gains, aircraft)
    write_levers(tree.getroot(), aircraft.engines, texts)
    open_all_tanks(tree.getroot())
    tree.write(file, encoding="utf-8", xml_declaration=True)
    attached = Attached(
        aircraft=folder.name,
        altitude_ft=ALTITUDE / FOOT,
        mass_kg=round(aircraft.read("inertia/weight-lbs") * POUND, 2),
        stall_kt=round(envelope.stall / KNOT, 2),
        fastest_kt=round(envelope.fastest / KNOT, 2),
        mach_limited=envelope.limited,
        engines=aircraft.engines,
        engine_kind=kind.kind,
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


def _shaped(
    name: str, envelope: Envelope, models: list[Linear], lag: float
) -> tuple[Envelope, list[Linear], Gains]:
    """Return envelope, models and gains, without the slowest point where no loop is stable there.

    Near the stall the slopes of some models have kinks. Cards begin at the slowest point that is left, or above.
    """
    try:
        return envelope, models, shape(name, models, lag)
    except SimulationError:
        return replace(envelope, points=envelope.points[1:]), models[1:], shape(name, models[1:], lag)


def _held(folder: Path, kind: Engines) -> HeldAircraft:
    import jsbsim

    try:
        return HeldAircraft(folder.name, folder, ALTITUDE, kind)
    except jsbsim.BaseError as error:  # such as a property that only another program defines
        raise SimulationError(f"{folder.name}: JSBSim stopped: {' '.join(str(error).split())}") from error


def _engines(folder: Path, root: ET.Element) -> Engines:
    """Return what the files say of the engines.

    Raises BadInputError for an aircraft without one that the bench can use.
    """
    tags, idle = set(), 0.0
    for element in root.iter("engine"):
        part = folder / "Engines" / f"{element.get('file')}.xml"
        inner = parse_xml(part).getroot() if part.is_file() else element
        idle = max(idle, float(inner.findtext(".//idlerpm") or 0.0))
        tags |= {inner.tag} if part.is_file() else {child.tag for child in inner}
    kinds = {ENGINE_KINDS[tag] for tag in tags if tag in ENGINE_KINDS}
    if not kinds:
        what = ", ".join(sorted(tag for tag in tags if tag.endswith("engine"))) or "none"
        raise BadInputError(
            f"aircraft {folder.name}: no engine that holds a level speed (piston, turboprop, electric, jet); "
            f"it has {what}"
        )
    return Engines(" and ".join(sorted(kinds)), idle)


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
