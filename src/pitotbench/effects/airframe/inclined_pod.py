"""A pod whose drag grows with the angle of attack."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED
from pitotbench.effects.expression import product, size, total
from pitotbench.effects.overlay import AxisFunction, Baseline, Overlay
from pitotbench.units import FOOT

NAME = "inclined_pod"
PARAMETERS = (
    Parameter("drag_area_m2", 0.08, -0.2, 0.8, "drag area with the pod along the flow"),
    Parameter("growth_per_rad2", 30.0, 0.0, 300.0, "relative growth of the drag, per square radian", shape=True),
)


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    area, growth = (size(NAME, p.name) for p in PARAMETERS)
    grown = total(1.0, product(growth, "aero/alpha-rad", "aero/alpha-rad"))
    drag = product("aero/qbar-psf", area, 1.0 / FOOT**2, grown)
    return Overlay(
        sizes=tuple((size(NAME, key), value) for key, value in sizes.items()),
        functions=(AxisFunction("DRAG", drag),),
    )


INCLINED_POD = AircraftEffect(
    name=NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=PARAMETERS,
    source="Hoerner 1965, Fluid-Dynamic Drag, ch. 13: bodies across the flow, cross-flow drag",
    what="A pod that the model lacks adds drag, and more at high angles of attack.",
    shows_in=RANGE_OF_AIRSPEED,  # the angle of attack is largest at the lowest airspeed
    variant_of="belly_pod",
    build=_build,
)
