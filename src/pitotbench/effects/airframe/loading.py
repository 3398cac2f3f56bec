"""Loading: more or less mass at the center of gravity, or a center of gravity farther aft or forward."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED, TURNING
from pitotbench.effects.expression import product, size
from pitotbench.effects.overlay import Baseline, MassPoint, Overlay
from pitotbench.units import FOOT, POUND

ARM = 100.0  # in, over which ballast is moved; any arm gives the same moment
_MASS, _AFT = size("mass", "mass_kg"), size("center_of_gravity", "aft_m")


def _mass(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    added = MassPoint(product(_MASS, 1.0 / POUND), baseline.center_of_gravity)
    return Overlay(sizes=((_MASS, sizes["mass_kg"]),), masses=(added,))


def _center_of_gravity(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    x, y, z = baseline.center_of_gravity
    # Ballast is added aft and the same ballast is taken away at the center of gravity: the mass stays, the moment
    # changes. The file's inches are the unit of the arm.
    moved = product(_AFT, 12.0 / (FOOT * ARM), "inertia/weight-lbs")
    masses = (MassPoint(moved, (x + ARM, y, z)), MassPoint(product(-1.0, moved), (x, y, z)))
    return Overlay(sizes=((_AFT, sizes["aft_m"]),), masses=masses)


MASS = AircraftEffect(
    name="mass",
    family="airframe",
    acts_on="aircraft",
    parameters=(Parameter("mass_kg", 150.0, -600.0, 600.0, "mass at the center of gravity beyond the loading"),),
    source="loading sheets: passengers, fuel and equipment to some 5 % of the weight",
    what="The airplane is heavier or lighter than the model.",
    shows_in=TURNING,
    build=_mass,
)

CENTER_OF_GRAVITY = AircraftEffect(
    name="center_of_gravity",
    family="airframe",
    acts_on="aircraft",
    parameters=(Parameter("aft_m", 0.06, -0.25, 0.25, "center of gravity behind that of the model"),),
    source="type certificate limits of the class: a range of some 0.3 m",
    what="The center of gravity is not where the model has it: elevator and pitch stability change.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_center_of_gravity,
)
