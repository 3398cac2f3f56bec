"""Engines that give less power for the fuel they burn."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import POWER
from pitotbench.effects.expression import difference, quotient, size
from pitotbench.effects.overlay import Baseline, Overlay, PropertySetting
from pitotbench.effects.propulsion.engines import left_and_right
from pitotbench.records.errors import BadInputError

NAME = "power_deficit"


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    settings = []
    for engine, key in zip(left_and_right(NAME, baseline), ("left_fraction", "right_fraction"), strict=True):
        fuel = baseline.engines[engine].fuel_per_power
        if fuel <= 0.0:
            raise BadInputError(f"effect {NAME!r} needs piston engines that state their bsfc; leave it out")
        # JSBSim's power is fuel flow over bsfc: a larger bsfc takes power away and leaves the fuel flow.
        path = f"propulsion/engine[{engine}]/bsfc-lbs_hphr"
        settings.append(PropertySetting(path, quotient(fuel, difference(1.0, size(NAME, key)))))
    return Overlay(sizes=tuple((size(NAME, key), value) for key, value in sizes.items()), settings=tuple(settings))


POWER_DEFICIT = AircraftEffect(
    name=NAME,
    family="propulsion",
    acts_on="aircraft",
    parameters=(
        Parameter("left_fraction", 0.06, -0.3, 0.5, "share of the left engine's indicated power that is missing"),
        Parameter("right_fraction", 0.03, -0.3, 0.5, "the same for the right engine"),
    ),
    source="Heywood 1988, Internal Combustion Engine Fundamentals: indicated power less friction; wear of 5 %",
    what="An engine gives less power than its manifold pressure and speed indicate.",
    shows_in=POWER,
    build=_build,
)
