"""Air that is warmer or colder than the case says, at all heights."""

from collections.abc import Mapping

from pitotbench.effects.effect import AirEffect, Parameter
from pitotbench.effects.excitation import CHANGING_HEIGHT
from pitotbench.effects.overlay import Baseline, Overlay


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    return Overlay(temperature_offset=sizes["warmer_k"])


NONSTANDARD_TEMPERATURE = AirEffect(
    name="nonstandard_temperature",
    family="air",
    acts_on="air",
    parameters=(Parameter("warmer_k", 10.0, -40.0, 40.0, "temperature above that of the case"),),
    source="ISO 2533 standard atmosphere and its hot and cold days (MIL-STD-210)",
    what="The air is warmer or colder than the case says: power, true airspeed and heights change.",
    shows_in=CHANGING_HEIGHT,
    build=_build,
)
