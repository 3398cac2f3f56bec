"""A drag polar that bends up at high lift, where the flow begins to separate from the wing."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import TURNING
from pitotbench.effects.expression import difference, operation, product, size
from pitotbench.effects.overlay import AxisFunction, Baseline, Overlay

NAME = "polar_bend"
PARAMETERS = (
    Parameter("factor", 0.05, -0.1, 0.4, "added drag coefficient over (C_L - onset)²"),
    Parameter("onset", 0.4, 0.0, 1.2, "lift coefficient at which it begins", shape=True),
)


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    factor, onset = (size(NAME, p.name) for p in PARAMETERS)
    beyond = operation("max", 0.0, difference(operation("sqrt", "aero/cl-squared"), onset))
    drag = product("aero/qbar-psf", "metrics/Sw-sqft", factor, beyond, beyond)
    return Overlay(
        sizes=tuple((size(NAME, key), value) for key, value in sizes.items()),
        functions=(AxisFunction("DRAG", drag),),
    )


POLAR_BEND = AircraftEffect(
    name=NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=PARAMETERS,
    source="Hoerner 1965, Fluid-Dynamic Drag, ch. 7: viscous drag due to lift grows with (C_L - C_L0)²",
    what="The wing has more drag at high lift: slower at low speed and in turns.",
    shows_in=TURNING,  # high lift without slow flight
    variant_of="induced_drag",
    build=_build,
)
