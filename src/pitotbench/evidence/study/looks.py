"""One look at a flight: one way to sense and to fit it."""

from dataclasses import dataclass, fields, replace
from typing import Any

from pitotbench.calibrate import Accuracies, CalibrationOptions
from pitotbench.evidence.study.changes import CHANGES
from pitotbench.records.case import DataSystem
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sense import data_system, record

# The paper's case is stated in full, so that no default of the calibrator changes it. The error is in the impact
# pressure alone (so no altitude equation), no sensor has a constant error, the wind is constant, the clocks agree.
COVERING = CalibrationOptions(
    model="inverse+",
    method="covering",
    error_location="impact",
    wind="constant",
    latency="given",
    accuracies=Accuracies(),
)
PAPER = replace(COVERING, method="paper", robust=False)  # as published: every row counts
_SIMULATED = 100.0  # Hz


@dataclass(frozen=True, slots=True)
class Look:
    """A data system, the options of the fit, and a change of the flight before it is sensed.

    `change` is a name of `CHANGES`, `level` the size of the change. `noise` multiplies the noise of the impact
    pressure, `gps_noise` that of the GPS velocity. `given_down` adds velocity down to the log of any system.
    `alone` leaves the noise of the impact pressure alone, as in the paper: every other sensor is exact. `form` is
    `scalar` (one output, airspeed) or `vector` (the components of ground velocity, by the paper's method).
    """

    das: str = "50/50"
    options: CalibrationOptions = PAPER
    change: str = "none"
    level: float = 0.0
    noise: float = 1.0
    gps_noise: float = 1.0
    given_down: bool = False
    alone: bool = False
    form: str = "scalar"

    @property
    def sensing(self) -> tuple[object, ...]:
        """The fields that determine the log. Looks with the same fields share one log."""
        return tuple(getattr(self, f.name) for f in fields(self) if f.name not in ("options", "form"))


def sense_look(flight: Flight, look: Look) -> tuple[Flight, FlightLog]:
    """Return the flight with the change of a look, and its log. Twice the simulator's rate is allowed.

    Raises BadInputError for impossible rates, UnknownNameError for an unknown change.
    """
    system = _exact(_system(look.das)) if look.alone else _system(look.das)
    changed = CHANGES[look.change](flight, look.level)
    if system.air_rate > _SIMULATED:
        changed = CHANGES["twice the rate"](changed, 0.0)
    noisy = replace(
        system,
        impact_pressure_noise=look.noise * system.impact_pressure_noise,
        velocity_noise=look.gps_noise * system.velocity_noise,
    )
    return changed, record(changed, noisy, flight.case.sensor_seed, True if look.given_down else None)


def _exact(system: DataSystem) -> DataSystem:
    """Return a data system in which only the impact pressure has noise, and no sensor rounds."""
    names = [f.name for f in fields(system) if f.name.endswith(("_noise", "_resolution"))]
    exact: dict[str, Any] = {name: 0.0 for name in names if name != "impact_pressure_noise"}
    return replace(system, **exact)


def _system(das: str) -> DataSystem:
    """Return a data system for rates up to 200 Hz, with the noise of the same kind of system at 100 Hz."""
    air, gps = (float(part) for part in das.split("/"))
    if air <= _SIMULATED:
        return data_system(das)
    known = data_system(f"{_SIMULATED:g}/{min(gps, _SIMULATED):g}")
    return replace(known, air_rate=air, gps_rate=gps)
