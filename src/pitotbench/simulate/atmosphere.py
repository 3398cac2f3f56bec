"""Set the air of a flight: steady wind, temperature above standard, turbulence and its seed."""

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
    """Anything whose properties can be set by their names in the property table, such as a `Plant`."""

    def set(self, name: str, value: float) -> None:
        """Set a property [SI] by its name in the table."""
        ...


@dataclass(frozen=True, slots=True)
class Air:
    """The air of a flight.

    `north`, `east` and `down` are the mean wind [m/s], the direction in which the air moves. `temperature_offset`
    is the temperature above standard [K]. `severity` is the Milspec index of the turbulence (0 none, 1 light,
    2 moderate) and `seed` starts its random numbers (1 to 2³¹−1).
    """

    north: float = 0.0
    east: float = 0.0
    down: float = 0.0
    temperature_offset: float = 0.0
    severity: int = 0
    seed: int = 1

    @classmethod
    def of(cls, case: Case, warmer: float = 0.0) -> "Air":
        """Return the air of a case, made warmer by `warmer` [K] for its effects.

        Raises UnknownNameError for an unknown turbulence name.
        """
        # A case says where the wind comes from, JSBSim where the air goes: hence the minus signs.
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
    """Return JSBSim's seed, 1 to 2³¹−1, for a truth seed."""
    # JSBSim makes the same turbulence of the seeds 0 and 1. Hashing also keeps neighboring seeds independent.
    word = int(np.random.SeedSequence(truth_seed).generate_state(1, np.uint64)[0])
    return 1 + word % LARGEST_SEED


def set_mean_wind(plant: Settable, air: Air) -> None:
    """Set the steady wind of a plant. Call it after the initial conditions are set.

    JSBSim can also set a wind with the initial conditions, but then it changes the airspeed that was asked for.
    """
    plant.set("mean_wind_north", air.north)
    plant.set("mean_wind_east", air.east)
    plant.set("mean_wind_down", air.down)


def start_turbulence(plant: Settable, air: Air) -> None:
    """Start the turbulence of the air. With severity 0 the air stays smooth."""
    if air.severity == 0:
        return
    # The type comes last: it switches the turbulence on, with seed and severity in place.
    plant.set("turbulence_seed", air.seed)
    plant.set("turbulence_low_wind", LOW_WIND[air.severity])
    plant.set("turbulence_severity", air.severity)
    plant.set("turbulence_type", MILSPEC_TUSTIN)
