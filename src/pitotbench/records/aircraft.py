"""What was found about an aircraft when the bench attached its autopilot to it and flew it."""

import os
from dataclasses import dataclass
from pathlib import Path

from platformdirs import user_cache_path

from pitotbench.units import Array

# Kinds of engines: an electric one needs no start; a turboprop's gas generator goes to idle with
# each restart.
ELECTRIC, TURBOPROP = "electric", "turboprop"


@dataclass(frozen=True, slots=True)
class Attached:
    """What was found about an aircraft at a height.

    Speeds are calibrated [kt]; `fastest_kt` is the maximum level speed, or that of Mach 0.7 where
    `mach_limited`. `missing` are channels of a flight that the aircraft does not serve. The lists
    have one value a trim point; `lever` is the throttle of level flight, `pitch_rate` and `bank`
    the gains [1/s]. `warnings` tell slopes of the wrong sign, and tables that level flight leaves.
    """

    aircraft: str
    altitude_ft: float
    mass_kg: float
    stall_kt: float
    fastest_kt: float
    mach_limited: bool
    engines: int
    engine_kind: str
    engine_time_s: float
    missing: tuple[str, ...]
    speed_kt: tuple[float, ...]
    alpha_deg: tuple[float, ...]
    lever: tuple[float, ...]
    pitch_rate: tuple[float, ...]
    bank: tuple[float, ...]
    climb: float
    speed: float
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class StepResponse:
    """One step of the autopilot, flown in smooth air.

    `time` [s] from the step, `change` of the quantity from its value before, in `unit`; `step` is
    the change asked for. `overshoot` is a share of the step; `settled` [s] is the time after which
    it stays within 10 %.
    """

    quantity: str
    unit: str
    speed_kt: float
    step: float
    time: Array
    change: Array
    overshoot: float
    settled: float


@dataclass(frozen=True, slots=True)
class ManeuverCheck:
    """One maneuver tried in light turbulence.

    `on_condition` is the share of the samples on its legs, steps or circles that is within the
    card's tolerances. `failure` says why it was not flown; the numbers are then None.
    """

    maneuver: str
    speeds_kt: tuple[float, ...]
    minutes: float | None = None
    on_condition: float | None = None
    failure: str = ""


@dataclass(frozen=True, slots=True)
class AircraftCheck:
    """What can be flown with an aircraft. `attached` is None for one with an autopilot of its own.

    `set_to_zero` are the properties that its files read and nothing writes.
    """

    aircraft: str
    attached: Attached | None
    steps: tuple[StepResponse, ...]
    maneuvers: tuple[ManeuverCheck, ...]
    set_to_zero: tuple[str, ...] = ()


def cache_folder() -> Path:
    """Return the folder of the cache: `$PITOTBENCH_CACHE`, else the system's for this user."""
    return Path(
        os.environ.get("PITOTBENCH_CACHE") or user_cache_path("pitotbench", appauthor=False)
    )
