"""Gusts that are stronger or weaker than the case says, with the same spectrum."""

from collections.abc import Mapping

from pitotbench.effects.effect import AirEffect, Parameter
from pitotbench.effects.excitation import STEADY_LEGS
from pitotbench.effects.expression import product, size
from pitotbench.effects.overlay import Baseline, Overlay, WindTerm

NAME = "turbulence_level"
_CHANGE = size(NAME, "change")


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    # JSBSim's gusts stay as they are; a share of them is added as a further wind.
    winds = tuple(
        WindTerm(toward, product(_CHANGE, f"atmosphere/turb-{toward}-fps")) for toward in ("north", "east", "down")
    )
    return Overlay(sizes=((_CHANGE, sizes["change"]),), winds=winds)


TURBULENCE_LEVEL = AirEffect(
    name=NAME,
    family="air",
    acts_on="air",
    parameters=(Parameter("change", 0.5, -1.0, 3.0, "gusts stronger by this share; -1 removes them"),),
    source="MIL-F-8785C 1980, §3.7: root-mean-square intensities, light to severe",
    what="The gusts are stronger or weaker than the case says; rotational gusts (p, q, r) stay the same.",
    shows_in=STEADY_LEGS,  # nothing but gusts moves the airplane there
    build=_build,
)
