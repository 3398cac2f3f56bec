"""More drag for the same lift: a wing that is less efficient than in the model."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import TURNING
from pitotbench.effects.expression import product, size
from pitotbench.effects.overlay import AxisFunction, Baseline, Overlay

NAME = "induced_drag"
_FACTOR = size(NAME, "factor")


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    drag = product("aero/qbar-psf", "metrics/Sw-sqft", _FACTOR, "aero/cl-squared")
    return Overlay(sizes=((_FACTOR, sizes["factor"]),), functions=(AxisFunction("DRAG", drag),))


INDUCED_DRAG = AircraftEffect(
    name=NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=(Parameter("factor", 0.010, -0.05, 0.08, "added k of C_D = C_D0 + k C_L²"),),
    source="lifting line, k = 1/(π A e): e 0.72 to 0.64 at an aspect ratio of 7.2 adds 0.008",
    what="The wing has more drag for its lift: slower at low speed and in turns.",
    shows_in=TURNING,
    build=_build,
)
