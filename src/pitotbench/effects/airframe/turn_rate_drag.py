"""Drag in proportion to the rate of turn instead of the bank."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import TURNING
from pitotbench.effects.expression import operation, product, size
from pitotbench.effects.overlay import AxisFunction, Baseline, Overlay
from pitotbench.units import DEGREE

NAME = "turn_rate_drag"
STANDARD_RATE = 3.0 * DEGREE  # rad/s
_COEFFICIENT = size(NAME, "coefficient_at_3degps")


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    rate = operation("abs", product("velocities/psidot-rad_sec", 1.0 / STANDARD_RATE))
    drag = product("aero/qbar-psf", "metrics/Sw-sqft", _COEFFICIENT, rate)
    return Overlay(sizes=((_COEFFICIENT, sizes["coefficient_at_3degps"]),), functions=(AxisFunction("DRAG", drag),))


TURN_RATE_DRAG = AircraftEffect(
    name=NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=(
        Parameter("coefficient_at_3degps", 0.004, -0.01, 0.04, "added drag coefficient at 3°/s, linear in it"),
    ),
    source="our form, an alternative to sin² of bank: rudder and aileron held against the turn grow with its rate",
    what="The airplane loses more speed in turns than the model.",
    shows_in=TURNING,
    variant_of="turn_drag",
    build=_build,
)
