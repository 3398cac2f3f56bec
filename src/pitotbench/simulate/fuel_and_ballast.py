"""Load an aircraft to a mass: with fuel in its tanks and, where fuel is not enough, ballast."""

from dataclasses import dataclass
from functools import cache

from pitotbench.effects import Overlay
from pitotbench.effects.expression import product
from pitotbench.effects.overlay import MassPoint
from pitotbench.records.errors import BadInputError
from pitotbench.simulate.baseline import read_baseline
from pitotbench.simulate.hangar import find_aircraft
from pitotbench.simulate.plant import Plant
from pitotbench.units import POUND

TANKS = ("propulsion/tank/contents-lbs", "propulsion/tank[1]/contents-lbs")
LEAST_FUEL = 0.1  # of what the file loads: half an hour of cruise, so that no card is flown with empty tanks
MOST_BALLAST = 1000.0  # kg: beyond it the mass is that of another airplane, or in another unit


@dataclass(frozen=True, slots=True)
class Loading:
    """The loading of an aircraft: `fuel`, the share of the fuel in its file (0 to 1), and `ballast` [kg]."""

    fuel: float = 1.0
    ballast: float = 0.0


@cache
def loaded_mass(aircraft: str) -> float:
    """Return the mass of an aircraft with the load and the fuel of its file [kg]."""
    plant = Plant.load(aircraft)
    plant.run_initial_conditions()  # until then JSBSim's mass lacks the fuel
    return plant.get("mass")


@cache
def loaded_fuel(aircraft: str) -> float:
    """Return the mass of the fuel in an aircraft's file [kg]."""
    plant = Plant.load(aircraft)
    return sum(plant.get(tank) for tank in tanks(plant)) * POUND


def tanks(plant: Plant) -> tuple[str, ...]:
    """Return the properties of the fuel in each tank of an aircraft [lb]; of more than two, the first two."""
    return tuple(tank for tank in TANKS if plant.serves(tank))


def mass_of(aircraft: str, loading: Loading) -> float:
    """Return the mass of an aircraft with a loading [kg]."""
    return loaded_mass(aircraft) - (1.0 - loading.fuel) * loaded_fuel(aircraft) + loading.ballast


def loading_of(aircraft: str, mass: float) -> Loading:
    """Return the loading that gives an aircraft a mass [kg]: fuel as far as the tanks allow, then ballast.

    Raises BadInputError where the mass cannot be that of this aircraft.
    """
    ballast = ballast_for(aircraft, mass, mass)
    return Loading(1.0 - (loaded_mass(aircraft) + ballast - mass) / loaded_fuel(aircraft), ballast)


def ballast_for(aircraft: str, lightest: float, heaviest: float) -> float:
    """Return the ballast [kg] that lets fuel alone account for all masses from `heaviest` to `lightest` [kg].

    It is negative where the aircraft is lighter than its file says with `LEAST_FUEL` in the tanks.
    Raises BadInputError where more than `MOST_BALLAST` would be needed.
    """
    full = loaded_mass(aircraft)
    least = full - (1.0 - LEAST_FUEL) * loaded_fuel(aircraft)
    ballast = max(0.0, heaviest - full) + min(0.0, lightest - least)
    if abs(ballast) > MOST_BALLAST:
        raise BadInputError(
            f"mass_kg goes from {lightest:.0f} to {heaviest:.0f} kg, and {aircraft} weighs {least:.0f} to "
            f"{full:.0f} kg: check the unit of the column, or name another aircraft"
        )
    return ballast


def ballast_overlay(aircraft: str, ballast: float) -> Overlay:
    """Return an overlay that puts ballast [kg] at the center of gravity of an aircraft; empty for no ballast."""
    if not ballast:
        return Overlay()
    place = read_baseline(find_aircraft(aircraft)).center_of_gravity
    # Times one: an expression must be XML, and a bare number is not.
    return Overlay(masses=(MassPoint(product(float(ballast) / POUND, 1.0), place),))


def load_fuel(plant: Plant, share: float) -> None:
    """Reduce the fuel in the tanks to a share of the load. Call it before the plant starts."""
    for tank in tanks(plant) if share != 1.0 else ():
        plant.set(tank, share * plant.get(tank))
