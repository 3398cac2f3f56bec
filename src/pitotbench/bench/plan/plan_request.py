"""The request for a plan: air, data system, speeds, minutes, box."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pitotbench import bench
from pitotbench.calibrate import CalibrationOptions
from pitotbench.records.case import TURBULENCE_SEVERITY, Case, DataSystem
from pitotbench.records.errors import BadInputError
from pitotbench.sense import data_system
from pitotbench.simulate import MANEUVERS
from pitotbench.units import KNOT, Array, from_si

_CURVE_STEP = 5.0 * KNOT
_NARROWEST = 20.0 * KNOT
_FEWEST_DRAWS = 2


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """The request for a plan.

    `base` holds the aircraft, the height, the expected wind and turbulence, and an error curve of the expected
    size and location. `system` is the data system or its name, and `options` are those of the calibration. An error
    of the static source narrows the bound as far as the system's height shows it. `speeds` is the range of
    calibrated airspeed [m/s] over which the bound is averaged. `minutes` is the time available, `want` [m/s] the
    wanted 2σ, and `box` [m] the side of the airspace; each is None where it does not matter.
    `draws` is the number of draws of gusts and sensor noise for each maneuver.

    Raises BadInputError or UnknownNameError for a request that makes no sense.
    """

    base: Case
    system: str | DataSystem = "20/1"
    speeds: tuple[float, float] = bench.SCORED_RANGE
    minutes: float | None = None
    want: float | None = None
    box: float | None = None
    maneuvers: tuple[str, ...] = tuple(MANEUVERS)
    draws: int = 16
    options: CalibrationOptions = field(default_factory=CalibrationOptions)

    def __post_init__(self) -> None:
        for name in self.maneuvers:
            _ = MANEUVERS[name]
        if self.base.turbulence not in TURBULENCE_SEVERITY:
            raise BadInputError(
                f"turbulence {self.base.turbulence!r}: expect one of {', '.join(TURBULENCE_SEVERITY)}"
            )
        low, high = self.speeds
        if not (low >= 20.0 * KNOT and high - low >= _NARROWEST):
            raise BadInputError("--speeds-kt LOW,HIGH: from 20 kt upward, and at least 20 kt apart")
        for name, value in (("--minutes", self.minutes), ("--want-kt", self.want), ("--box-nm", self.box)):
            if value is not None and not 0.0 < value < float("inf"):
                raise BadInputError(f"{name} must be above zero; leave it out where it does not matter")
        if self.draws < _FEWEST_DRAWS:
            raise BadInputError(f"--draws: at least {_FEWEST_DRAWS} flights make an average")

    @property
    def das(self) -> DataSystem:
        """The data system."""
        return data_system(self.system) if isinstance(self.system, str) else self.system

    @property
    def airspeeds(self) -> Array:
        """The airspeeds [m/s], (n,), at which the bound is averaged: every 5 kt of the wanted range."""
        low, high = self.speeds
        steps = np.arange(int((high - low) / _CURVE_STEP + 1e-6) + 1, dtype=np.float64)
        return np.asarray(low + _CURVE_STEP * steps, dtype=np.float64)

    def case(self, maneuver: str, card: dict[str, Any] | None = None) -> Case:
        """Return the case of a maneuver in still air, with its speeds scaled to the wanted range.

        Each speed of a card keeps its relative place between the slowest and the fastest one.
        """
        speeds = np.array(MANEUVERS[maneuver].card.speeds)
        place = (speeds - speeds.min()) / np.ptp(speeds)
        low, high = self.speeds
        wanted = [written(v, "kt") for v in low + place * (high - low)]
        changes = {"speeds_kt": wanted, **(card or {})}
        return replace(self.base, maneuver=maneuver, card=changes, turbulence="none")


def written(value: float, suffix: str) -> float:
    """Return an SI value as a card's file has it: in the unit of a suffix ("" for a count), to a millionth."""
    return round(float(from_si(value, suffix) if suffix else value), 6)
