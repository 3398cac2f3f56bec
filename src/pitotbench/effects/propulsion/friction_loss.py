"""Engines that lose a constant power at any setting: friction, or a driven accessory."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import POWER
from pitotbench.effects.expression import product, size, total
from pitotbench.effects.overlay import Baseline, Overlay, PropertySetting
from pitotbench.effects.propulsion.engines import left_and_right

NAME = "friction_loss"
KILOWATT = 1000.0 / 745.699872  # hp


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    settings = tuple(
        PropertySetting(
            f"propulsion/engine[{i}]/friction-hp",
            total(baseline.engines[i].friction, product(KILOWATT, size(NAME, key))),
        )
        for i, key in zip(left_and_right(NAME, baseline), ("left_kw", "right_kw"), strict=True)
    )
    return Overlay(sizes=tuple((size(NAME, key), value) for key, value in sizes.items()), settings=settings)


FRICTION_LOSS = AircraftEffect(
    name=NAME,
    family="propulsion",
    acts_on="aircraft",
    parameters=(
        Parameter("left_kw", 8.0, -20.0, 80.0, "power that the left engine loses"),
        Parameter("right_kw", 4.0, -20.0, 80.0, "power that the right engine loses"),
    ),
    source="Heywood 1988, Internal Combustion Engine Fundamentals, ch. 13: friction and accessories",
    what="An engine loses a constant power.",
    shows_in=POWER,  # a constant power is a larger share of a low one
    variant_of="power_deficit",
    build=_build,
)
