"""Governors set to another propeller speed."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import POWER
from pitotbench.effects.expression import size, total
from pitotbench.effects.overlay import Baseline, Overlay, PropertySetting
from pitotbench.effects.propulsion.engines import require_declared

NAME = "governor_speed"
_OFFSET = size(NAME, "offset_rpm")
GOVERNOR = "powerplant/governor-rpm"


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    require_declared(NAME, baseline, GOVERNOR)
    setting = PropertySetting(GOVERNOR, total(baseline.declared[GOVERNOR], _OFFSET))
    return Overlay(sizes=((_OFFSET, sizes["offset_rpm"]),), settings=(setting,))


GOVERNOR_SPEED = AircraftEffect(
    name=NAME,
    family="propulsion",
    acts_on="aircraft",
    parameters=(Parameter("offset_rpm", -75.0, -500.0, 100.0, "propeller speed above that of the model"),),
    source="governor stops are set to some 25 rpm; a pilot's lever to 50 rpm (estimate)",
    what="The propellers turn faster or slower than in the model.",
    shows_in=POWER,  # the governor holds its speed at high power only
    build=_build,
)
