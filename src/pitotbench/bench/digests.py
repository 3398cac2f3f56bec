"""Flights kept on disk under a digest of their case, of the code and of the aircraft's files."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, lru_cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from pitotbench.logbook.columns import atomic
from pitotbench.records.case import Case
from pitotbench.records.case_file import case_table
from pitotbench.records.flight import Flight
from pitotbench.sensing.recorder import CALIBRATION_CHANNELS
from pitotbench.simulation.aircraft import PACKAGE, find_aircraft
from pitotbench.simulation.sortie import fly

# Flights kept on disk, so that a long campaign need not fly them again when only the calibrator has changed.
# The key of a flight is its case, without the pressure error and the sensors, and the simulator's version. Only
# the channels that air data and GPS velocity need are kept.

_CHANNELS = ("time", *CALIBRATION_CHANNELS)


@dataclass(frozen=True, slots=True)
class FlightStore:
    """A folder of flights."""

    folder: Path

    def fly(self, case: Case) -> Flight:
        """Return the flight of a case. It is read from the folder, or else flown and kept there."""
        path = self.folder / f"{case.maneuver}-{case.truth_seed}-{_digest(case)}.npz"
        if path.exists():
            return _read(path, case)
        flight = fly(case, channels=CALIBRATION_CHANNELS)
        self._keep(flight, path)
        return flight

    def _keep(self, flight: Flight, path: Path) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        arrays: dict[str, Any] = {name: flight[name] for name in _CHANNELS}
        labels, label = np.unique(flight.segment, return_inverse=True)
        arrays |= {"labels": labels, "label": label.astype(np.uint8), "on_condition": flight.on_condition}
        with atomic(path) as scratch, scratch.open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays)


def _read(path: Path, case: Case) -> Flight:
    with np.load(path) as kept:
        segment = kept["labels"][kept["label"]]
        return Flight(case, {name: kept[name] for name in _CHANNELS}, segment, kept["on_condition"])


def _digest(case: Case) -> str:
    flown = tomli_w.dumps(case_table(case, omit=("pressure_error", "das", "sensor_seed", "accuracy")))
    return sha256(f"{version('jsbsim')}\n{flown}".encode()).hexdigest()[:16]


# The digests of the code and of the aircraft files that decide a result, for the keys of what is kept.

# Packages whose code shows results and cannot change them. All other code counts: a list of the code that counts
# would miss a module that a later change adds.
NOT_DECIDING = ("cli", "show")
# What flies and calibrates needs neither the reconciler nor most of the bench.
_NOT_FLYING = (*NOT_DECIDING, "reconciliation", "bench")

_FLYING_BENCH = ("bench/flights.py", "bench/campaign_task.py")


@cache
def code_digest() -> str:
    """Return the digest of the code that decides the result of a flight, 16 hexadecimal digits."""
    return package_digest(_NOT_FLYING, _FLYING_BENCH)


def package_digest(without: Iterable[str] = (), but: Iterable[str] = ()) -> str:
    """Return the digest of the code of this package, `without` some packages `but` with some of their modules."""
    left_out, kept = {*without}, {*but}
    paths = (file.relative_to(PACKAGE) for file in sorted(PACKAGE.rglob("*.py")))
    return _digest_of(PACKAGE, (p for p in paths if p.parts[0] not in left_out or p.as_posix() in kept))


def aircraft_digest(name: str) -> str:
    """Return the digest of the files of an aircraft. Raises UnknownNameError for one that does not exist."""
    folder = find_aircraft(name)
    files = (file for file in sorted(folder.rglob("*")) if file.is_file())
    # The files may change while this process runs: their sizes and times say whether they are to be read again.
    stats = ((file.relative_to(folder), file.stat()) for file in files)
    return _aircraft_digest(folder, tuple((path, stat.st_size, stat.st_mtime_ns) for path, stat in stats))


@lru_cache(maxsize=64)
def _aircraft_digest(folder: Path, stamps: tuple[tuple[Path, int, int], ...]) -> str:
    return _digest_of(folder, (path for path, _, _ in stamps))


def _digest_of(root: Path, paths: Iterable[Path]) -> str:
    """Return the digest of files by their paths below a folder, 16 hexadecimal digits."""
    digest = sha256()
    for path in paths:
        digest.update(repr((path.as_posix(), (root / path).read_bytes())).encode())
    return digest.hexdigest()[:16]
