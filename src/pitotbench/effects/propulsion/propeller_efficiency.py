"""Propellers that give less thrust for their power: damaged, or of another type than in the model."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import POWER
from pitotbench.effects.expression import product, size
from pitotbench.effects.overlay import Baseline, BodyForce, Overlay
from pitotbench.effects.propulsion.engines import left_and_right

NAME = "propeller_efficiency"


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    forces = [
        BodyForce(product(size(NAME, key), f"propulsion/engine[{i}]/thrust-lbs"), baseline.engines[i].location)
        for i, key in zip(left_and_right(NAME, baseline), ("left_change", "right_change"), strict=True)
    ]
    return Overlay(sizes=tuple((size(NAME, key), value) for key, value in sizes.items()), forces=tuple(forces))


PROPELLER_EFFICIENCY = AircraftEffect(
    name=NAME,
    family="propulsion",
    acts_on="aircraft",
    parameters=(
        Parameter("left_change", -0.04, -0.4, 0.2, "relative change of the left propeller's thrust"),
        Parameter("right_change", -0.04, -0.4, 0.2, "the same for the right propeller"),
    ),
    source="McCormick 1995: installed efficiency errs by some 5 %; the change is a force at the propeller",
    what="A propeller gives less thrust than in the model for the same power.",
    shows_in=POWER,
    build=_build,
)
