"""Drag that appears only in a bank: deflected surfaces, a skid, the pilot's control movements in the turn."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import TURNING
from pitotbench.effects.expression import operation, product, size
from pitotbench.effects.overlay import AxisFunction, Baseline, Overlay

NAME = "turn_drag"
SIN_SQUARED_30 = 0.25
_COEFFICIENT = size(NAME, "coefficient_at_30deg")


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    # sin² is the same for both sides and flat in level flight; over that of 30° it gives the coefficient there.
    sine = operation("sin", "attitude/phi-rad")
    drag = product("aero/qbar-psf", "metrics/Sw-sqft", _COEFFICIENT, sine, sine, 1.0 / SIN_SQUARED_30)
    return Overlay(sizes=((_COEFFICIENT, sizes["coefficient_at_30deg"]),), functions=(AxisFunction("DRAG", drag),))


TURN_DRAG = AircraftEffect(
    name=NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=(
        Parameter("coefficient_at_30deg", 0.005, -0.01, 0.04, "added drag coefficient at 30° of bank, as sin²"),
    ),
    source="Martos, Kiszely and Foster 2011: power had to be added in turns in flight, not in the simulator",
    what="The airplane loses more speed in turns than the model.",
    shows_in=TURNING,
    build=_build,
)
