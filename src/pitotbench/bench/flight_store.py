"""Flights kept on disk, so that a long campaign need not fly them again when only the calibrator has changed.

The key of a flight is its case, without the pressure error and the sensors, and the simulator's version. Only the
channels that air data and GPS velocity need are kept.
"""

from dataclasses import dataclass
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from pitotbench.logbook import atomic
from pitotbench.records.case import Case
from pitotbench.records.case_file import case_table
from pitotbench.records.flight import Flight
from pitotbench.sense import CALIBRATION_CHANNELS
from pitotbench.simulate import fly

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
