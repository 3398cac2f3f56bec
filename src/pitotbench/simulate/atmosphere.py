"""The air a flight meets: steady wind, non-standard temperature, turbulence and its seed."""

from dataclasses import dataclass
from math import cos, sin
from typing import Protocol

import numpy as np

from pitotbench.catalog import Catalog
from pitotbench.records.case import TURBULENCE_SEVERITY, Case
from pitotbench.units import KNOT

MILSPEC_TUSTIN = 4  # JSBSim's turb-type: MIL-F-8785C spectra, filters discretized by Tustin's rule
# Wind at 20 ft that MIL-F-8785C ties to light, moderate and severe turbulence; used below 2,000 ft only.
LOW_WIND = (0.0, 15.0 * KNOT, 30.0 * KNOT, 45.0 * KNOT)
LARGEST_SEED = 2**31 - 1

SEVERITY = Catalog("turbulence", TURBULENCE_SEVERITY)


class Settable(Protocol):
    """Anything that takes values by the names of the property table."""

    def set(self, name: str, value: float) -> None: ...


@dataclass(frozen=True, slots=True)
class Air:
    """Mean wind, toward north, east and down [m/s]; temperature above standard [K]; Milspec severity
    (0 none, 1 light, 2 moderate) and the seed of its random numbers (1 .. 2³¹−1)."""

    north: float = 0.0
    east: float = 0.0
    down: float = 0.0
    temperature_offset: float = 0.0
    severity: int = 0
    seed: int = 1

    @classmethod
    def of(cls, case: Case, warmer: float = 0.0) -> "Air":
        """The air of a case, `warmer` [K] by its effects.

        Raises UnknownNameError for an unknown turbulence name.
        """
        wind = case.wind
        return cls(
            north=-wind.speed * cos(wind.from_direction),
            east=-wind.speed * sin(wind.from_direction),
            down=-wind.up,
            temperature_offset=case.temperature_offset + warmer,
            severity=SEVERITY[case.turbulence],
            seed=turbulence_seed(case.truth_seed),
        )


def turbulence_seed(truth_seed: int) -> int:
    """JSBSim's seed, 1 .. 2³¹−1, of a truth seed: 0 and 1 give JSBSim one and the same turbulence."""
    word = int(np.random.SeedSequence(truth_seed).generate_state(1, np.uint64)[0])
    return 1 + word % LARGEST_SEED


def blow(plant: Settable, air: Air) -> None:
    """Set the steady wind; JSBSim's wind properties name where the air goes, as `Air` does.

    Call after the initial conditions: JSBSim's own wind initial conditions spoil the airspeed.
    """
    plant.set("mean_wind_north", air.north)
    plant.set("mean_wind_east", air.east)
    plant.set("mean_wind_down", air.down)


def stir(plant: Settable, air: Air) -> None:
    """Start the turbulence of the air; severity 0 leaves it smooth."""
    if air.severity == 0:
        return
    plant.set("turbulence_seed", air.seed)
    plant.set("turbulence_low_wind", LOW_WIND[air.severity])
    plant.set("turbulence_severity", air.severity)
    plant.set("turbulence_type", MILSPEC_TUSTIN)
