"""Make an aircraft flyable, once: import it, explore it, shape its loops, write its autopilot."""

import os
import shutil
import time
import xml.etree.ElementTree as ET
from collections.abc import Set
from contextlib import suppress
from dataclasses import replace
from functools import cache
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp

from pitotbench.records import BadInputError
from pitotbench.records.aircraft import ELECTRIC, TURBOPROP, Attached, cache_folder
from pitotbench.simulation.aircraft_files import (
    FILE,
    SimulationError,
    has_autopilot,
    parse_xml,
    read_record,
    write_record,
)
from pitotbench.simulation.aircraft_import import aircraft_name, import_aircraft, left_tables
from pitotbench.simulation.autopilot.autopilot_file import (
    open_all_tanks,
    write_autopilot,
    write_levers,
)
from pitotbench.simulation.autopilot.envelope import explore
from pitotbench.simulation.autopilot.frozen_aircraft import Engines, FrozenAircraft
from pitotbench.simulation.autopilot.linear_model import engine_time, linearize, wrong_slopes
from pitotbench.simulation.autopilot.loops import shape
from pitotbench.simulation.properties import CHANNELS
from pitotbench.units import DEGREE, FOOT, KNOT, POUND
from pitotbench.version import version_of

ALTITUDE = 6000.0 * FOOT  # for which the loops are shaped: that of the cards
MOST_KEPT = 50  # attached aircraft in the cache
DAY = 86_400.0  # s
# Modules of the simulation by which a kept aircraft was made, with all of this package.
_DECIDING = ("aircraft_files.py", "aircraft_import.py", "properties.py")
AUTOPILOT = Path("Systems", "attached-autopilot.xml")
SURFACES = {"elevator": "elevator", "aileron": "left-aileron", "rudder": "rudder"}
ENGINE_KINDS = {
    "piston_engine": "piston",
    "turbine_engine": "jet",
    "turboprop_engine": TURBOPROP,
    "electric_engine": ELECTRIC,
    "brushless_dc_motor": ELECTRIC,
}


def attach(source: Path) -> Path:
    """Return the folder of an aircraft with the bench's autopilot.

    `source` is a JSBSim file or its folder. The folder is made the first time, which takes seconds,
    and kept in the cache under a digest of all files. It is made again where another process has
    deleted it. Raises BadInputError for files that are not taken, SimulationError for an aircraft
    that cannot be flown.
    """
    if not source.exists():
        raise BadInputError(f"{source}: no such aircraft file or folder")
    source = source.resolve()
    main = source / f"{source.name}.xml"
    stamps = tuple(file.stat().st_mtime_ns for file in (source, main) if file.exists())
    shelf = cache_folder() / "aircraft"
    kept, files = _attach(source, stamps, shelf)
    if not _is_whole(kept, files):
        _attach.cache_clear()
        kept, files = _attach(source, stamps, shelf)
    with suppress(OSError):  # the cache spares what is in use
        os.utime(kept.parent)
    return kept


@cache
def _attach(source: Path, stamps: tuple[int, ...], shelf: Path) -> tuple[Path, frozenset[Path]]:
    """Return the folder of the aircraft in the cache, and the files that it must hold."""
    name = aircraft_name(source)
    with TemporaryDirectory(prefix="pitotbench-") as scratch:
        folder = Path(scratch) / name
        folder.mkdir()
        import_aircraft(source, folder)
        flyable = has_autopilot(folder)  # a copy or a variant of a flyable one has it
        if flyable and (record := read_record(source if source.is_dir() else source.parent)):
            write_record(folder, record)
        files = {file.relative_to(folder) for file in folder.rglob("*.*")}
        files |= set() if flyable else {AUTOPILOT, Path(FILE)}
        place = shelf / f"{name}-{_digest(folder)}"
        if not _is_whole(place / name, files):
            if not flyable:
                make_flyable(folder)
            place = _keep(folder, place, files)
        return place / name, frozenset(files)


def _is_whole(folder: Path, files: Set[Path]) -> bool:
    return all((folder / file).is_file() for file in files)


def make_flyable(folder: Path) -> Attached:
    """Add the autopilot to the aircraft in a folder of its own, and write and return its record.

    Raises SimulationError, which says why, where the aircraft cannot be flown.
    """
    file = folder / f"{folder.name}.xml"
    tree = parse_xml(file)
    kind = engines_of(folder, tree.getroot())
    import jsbsim

    try:
        aircraft = FrozenAircraft(folder.name, folder, ALTITUDE, kind)
    except jsbsim.BaseError as error:  # such as a property that only another program defines
        raise SimulationError(
            f"{folder.name}: JSBSim stopped: {' '.join(str(error).split())}"
        ) from error
    envelope = explore(aircraft)
    lag = engine_time(aircraft, envelope.points[len(envelope.points) // 2])
    models = [linearize(aircraft, point) for point in envelope.points]
    try:
        gains = shape(folder.name, models, lag)
    except SimulationError:
        # Near the stall the slopes of some models have kinks: then cards begin at the next point,
        # or above.
        envelope, models = replace(envelope, points=envelope.points[1:]), models[1:]
        gains = shape(folder.name, models, lag)
    still = [
        name for name, path in SURFACES.items() if not aircraft.moves(name, f"fcs/{path}-pos-rad")
    ]
    missing = tuple(c.name for c in CHANNELS if c.name in still or not aircraft.serves(c.path))
    texts = "".join(f.read_text(encoding="utf-8") for f in sorted(folder.rglob("*.xml")))
    write_autopilot(folder / AUTOPILOT, envelope, models, gains, aircraft)
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
        warnings=(
            *wrong_slopes(aircraft, models),
            *left_tables(tree.getroot(), [point.alpha for point in envelope.points]),
        ),
    )
    write_record(folder, attached)
    return attached


def engines_of(folder: Path, root: ET.Element) -> Engines:
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
            f"aircraft {folder.name}: no engine that holds a level speed (piston, turboprop, "
            f"electric, jet); it has {what}"
        )
    return Engines(" and ".join(sorted(kinds)), idle)


def _digest(folder: Path) -> str:
    """Return the digest of an aircraft's files and of the code that attaches it."""
    here = Path(__file__).parent
    code = [
        *sorted(here.glob("*.*")),
        *(here.parent / name for name in _DECIDING),
    ]
    digest = sha256(
        repr([f"{name} {version_of(name)}" for name in ("jsbsim", "numpy", "scipy")]).encode()
    )
    for root, files in (
        (here.parent, code),
        (folder, sorted(f for f in folder.rglob("*") if f.is_file())),
    ):
        for file in files:
            digest.update(repr((file.relative_to(root).as_posix(), file.read_bytes())).encode())
    return digest.hexdigest()[:16]


def _keep(made: Path, place: Path, files: Set[Path]) -> Path:
    """Put a finished aircraft's folder into the cache, completely or not at all, and return it."""
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=place.parent, prefix=".") as scratch:
            copy = Path(shutil.copytree(made.parent, Path(scratch) / "made"))
            if place.is_dir() and not _is_whole(place / made.name, files):  # half of it was deleted
                place.rename(Path(scratch) / "damaged")
            with suppress(OSError):  # another process has just made the same
                copy.rename(place)
        if _is_whole(place / made.name, files):
            _prune(place.parent)
            return place
    except OSError:  # a cache that cannot be written
        pass
    return Path(shutil.copytree(made.parent, mkdtemp(prefix="pitotbench-"), dirs_exist_ok=True))


def _prune(shelf: Path) -> None:
    """Remove all but the aircraft used last, and those used within a day, which may be in use."""
    stamps = sorted((p.stat().st_mtime, p) for p in shelf.iterdir() if p.is_dir())
    for used, old in stamps[:-MOST_KEPT]:
        if used < time.time() - DAY:
            shutil.rmtree(old, ignore_errors=True)
