"""A front passes, and the wind changes from one vector to another within seconds."""

from collections.abc import Mapping

import numpy as np

from pitotbench.effects.air.recorded_time import ELAPSED, clipped, elapsed
from pitotbench.effects.effect import AirEffect, Parameter
from pitotbench.effects.excitation import TURNING
from pitotbench.effects.expression import difference, product, quotient, size
from pitotbench.effects.overlay import Baseline, Overlay, WindTerm
from pitotbench.effects.signals import Signals
from pitotbench.units import FOOT, Array

NAME = "sea_breeze_front"
PARAMETERS = (
    Parameter("north_mps", 2.5, -20.0, 20.0, "step of the wind toward north"),
    Parameter("east_mps", -2.0, -20.0, 20.0, "step of the wind toward east"),
    Parameter("at_s", 120.0, 0.0, 1e5, "time since the first sample at which it begins", shape=True),
    Parameter("width_s", 10.0, 0.5, 600.0, "duration of the change", shape=True),
)


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    north, east, at, width = (size(NAME, p.name) for p in PARAMETERS)
    # The step is a ramp of the given width, held at 0 before it and at 1 after it. JSBSim's winds are in ft/s.
    share = clipped(quotient(difference(ELAPSED, at), width))
    winds = tuple(
        WindTerm(toward, product(path, 1.0 / FOOT, share)) for toward, path in (("north", north), ("east", east))
    )
    return Overlay(sizes=tuple((size(NAME, key), value) for key, value in sizes.items()), winds=winds)


def _wind(signals: Signals, sizes: Mapping[str, float]) -> tuple[Array, Array, Array]:
    share = np.clip((elapsed(signals) - sizes["at_s"]) / sizes["width_s"], 0.0, 1.0)
    return sizes["north_mps"] * share, sizes["east_mps"] * share, np.zeros_like(share)


SEA_BREEZE_FRONT = AirEffect(
    name=NAME,
    family="air",
    acts_on="air",
    parameters=PARAMETERS,
    source="Simpson 1994, Sea Breeze and Local Winds: changes of 2 to 8 m/s across some hundred meters",
    what="A front passes, and the wind changes within seconds.",
    shows_in=TURNING,
    build=_build,
    wind=_wind,
)
