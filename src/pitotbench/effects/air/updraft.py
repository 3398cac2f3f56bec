"""Rising or sinking air for some time, with edges of a few seconds."""

from collections.abc import Mapping

import numpy as np

from pitotbench.effects.air.recorded_time import ELAPSED, clipped, elapsed
from pitotbench.effects.effect import AirEffect, Parameter
from pitotbench.effects.excitation import STEADY_LEGS
from pitotbench.effects.expression import difference, operation, product, quotient, size, total
from pitotbench.effects.overlay import Baseline, Overlay, WindTerm
from pitotbench.effects.signals import Signals
from pitotbench.units import FOOT, Array

NAME = "updraft"
EDGE = 5.0  # s: a thermal's edge of some 300 m at 120 kt; an instant step would be no flow of air
PARAMETERS = (
    Parameter("up_mps", 1.0, -10.0, 10.0, "speed of the rising air"),
    Parameter("from_s", 60.0, 0.0, 1e5, "time since the first sample at which it begins", shape=True),
    Parameter("for_s", 60.0, 5.0, 1e5, "duration", shape=True),
)


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    up, begin, last = (size(NAME, p.name) for p in PARAMETERS)
    rise = quotient(difference(ELAPSED, begin), EDGE)
    fall = quotient(difference(total(begin, last), ELAPSED), EDGE)
    share = clipped(operation("min", rise, fall))
    wind = WindTerm("down", product(up, -1.0 / FOOT, share))
    return Overlay(sizes=tuple((size(NAME, key), value) for key, value in sizes.items()), winds=(wind,))


def _wind(signals: Signals, sizes: Mapping[str, float]) -> tuple[Array, Array, Array]:
    since = elapsed(signals) - sizes["from_s"]
    share = np.clip(np.minimum(since, sizes["for_s"] - since) / EDGE, 0.0, 1.0)
    return np.zeros_like(since), np.zeros_like(since), -sizes["up_mps"] * share


UPDRAFT = AirEffect(
    name=NAME,
    family="air",
    acts_on="air",
    parameters=PARAMETERS,
    source="mountain waves and thermals: 1 to 5 m/s over kilometers (FAA Glider Flying Handbook, ch. 9)",
    what="The airplane flies through rising or sinking air.",
    shows_in=STEADY_LEGS,  # power and height are held, so that only the air rises
    build=_build,
    wind=_wind,
)
