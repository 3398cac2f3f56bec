"""Throttles that differ while their levers stand together."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import POWER
from pitotbench.effects.expression import product, size
from pitotbench.effects.overlay import Baseline, Overlay, PropertySetting
from pitotbench.effects.propulsion.engines import require_declared

NAME = "throttle_rigging"
_PATHS = {"left": "ap/throttle-bias-left-norm", "right": "ap/throttle-bias-right-norm"}


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    require_declared(NAME, baseline, *_PATHS.values())
    # Times one: an expression must be XML, and the bare path of a property is not.
    settings = tuple(PropertySetting(path, product(size(NAME, side), 1.0)) for side, path in _PATHS.items())
    return Overlay(sizes=tuple((size(NAME, key), value) for key, value in sizes.items()), settings=settings)


THROTTLE_RIGGING = AircraftEffect(
    name=NAME,
    family="propulsion",
    acts_on="aircraft",
    parameters=(
        Parameter("left", 0.02, -0.2, 0.2, "left throttle more open, share of the plate's travel"),
        Parameter("right", -0.02, -0.2, 0.2, "right throttle more open"),
    ),
    source="cable rigging: lever stagger of some 2 % of travel (estimate)",
    what="The engines give different power with the levers together.",
    shows_in=POWER,
    build=_build,
)
