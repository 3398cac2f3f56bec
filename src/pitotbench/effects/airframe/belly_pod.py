"""A pod or antenna that the model lacks: drag in proportion to dynamic pressure."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED
from pitotbench.effects.expression import product, size
from pitotbench.effects.overlay import AxisFunction, Baseline, Overlay
from pitotbench.units import FOOT

NAME = "belly_pod"
_AREA = size(NAME, "drag_area_m2")


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    drag = product("aero/qbar-psf", _AREA, 1.0 / FOOT**2)
    return Overlay(sizes=((_AREA, sizes["drag_area_m2"]),), functions=(AxisFunction("DRAG", drag),))


BELLY_POD = AircraftEffect(
    name=NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=(Parameter("drag_area_m2", 0.1, -0.2, 0.8, "drag area: drag over dynamic pressure"),),
    source="Hoerner 1965, Fluid-Dynamic Drag, ch. 13: 0.1 on the frontal area of a fairing to 1 for blunt bodies; "
    "Martos, Kiszely and Foster 2011: the pod on the airplane, not in the model",
    what="A pod or antenna that the model lacks adds drag: less speed for the power.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_build,
)
