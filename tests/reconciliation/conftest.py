"""One flight, flown once, sensed with effects in its sensors; another with an effect on its
airframe.
"""

from collections.abc import Callable
from dataclasses import replace

import pytest

from pitotbench import Case, Flight, FlightLog, fly, sense
from pitotbench.effects import EFFECTS
from pitotbench.records.case import EffectSpec

Sensed = Callable[..., FlightLog]


@pytest.fixture(scope="session")
def flight() -> Flight:
    return fly(Case(maneuver="rapid_decel", turbulence="light", truth_seed=11))


@pytest.fixture(scope="session")
def sensed(flight: Flight) -> Sensed:
    """The log of the flight with effects on the sensors at their typical sizes."""

    def log(*names: str, das: str = "20/1") -> FlightLog:
        effects = tuple(EffectSpec(name, EFFECTS[name].typical()) for name in names)
        return sense(replace(flight, case=replace(flight.case, effects=effects)), das)

    return log
