"""Flaps or gear that are not fully up. Lift and drag follow from the flap and gear terms of the aircraft."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED
from pitotbench.effects.expression import product, size
from pitotbench.effects.overlay import Baseline, Overlay, PropertySetting

_FLAP, _GEAR = size("flap_not_up", "extension"), size("gear_not_up", "extension")
LEVERS = ("fcs/gear-lever-norm", "gear/gear-cmd-norm")  # the aircraft's lever where it has one, else JSBSim's


def _flap(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    # Times one: an expression must be XML, and the bare path of a property is not.
    held = PropertySetting("fcs/flap-cmd-norm", product(_FLAP, 1.0))
    return Overlay(sizes=((_FLAP, sizes["extension"]),), settings=(held,))


def _gear(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    lever = LEVERS[0] if LEVERS[0] in baseline.declared else LEVERS[1]
    return Overlay(sizes=((_GEAR, sizes["extension"]),), settings=(PropertySetting(lever, product(_GEAR, 1.0)),))


FLAP_NOT_UP = AircraftEffect(
    name="flap_not_up",
    family="airframe",
    acts_on="aircraft",
    parameters=(Parameter("extension", 0.15, 0.005, 1.0, "flaps down by this share of their travel"),),
    source="a rigging error or a forgotten lever; lift and drag are those of the aircraft's flaps",
    what="The flaps are not fully up.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_flap,
)

GEAR_NOT_UP = AircraftEffect(
    name="gear_not_up",
    family="airframe",
    acts_on="aircraft",
    parameters=(Parameter("extension", 0.3, 0.01, 1.0, "gear down by this share; a gear door is part of it"),),
    source="a door or a leg that does not close; the drag is that of the aircraft's gear",
    what="The gear is not fully up.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_gear,
)
