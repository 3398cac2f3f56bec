"""A wind that oscillates: waves in the lee of hills."""

from collections.abc import Mapping
from math import pi

import numpy as np

from pitotbench.effects.air.recorded_time import ELAPSED, elapsed
from pitotbench.effects.effect import AirEffect, Parameter
from pitotbench.effects.excitation import TURNING
from pitotbench.effects.expression import operation, product, quotient, size
from pitotbench.effects.overlay import Baseline, Overlay, WindTerm
from pitotbench.effects.signals import Signals
from pitotbench.units import FOOT, Array

NAME = "wind_oscillation"
PARAMETERS = (
    Parameter("north_mps", 0.8, -10.0, 10.0, "amplitude of the wind toward north"),
    Parameter("east_mps", -0.6, -10.0, 10.0, "amplitude of the wind toward east"),
    Parameter("period_s", 400.0, 20.0, 7200.0, "period of the oscillation, which begins at zero", shape=True),
)


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    north, east, period = (size(NAME, p.name) for p in PARAMETERS)
    swing = operation("sin", quotient(product(2.0 * pi, ELAPSED), period))
    winds = tuple(
        WindTerm(toward, product(path, 1.0 / FOOT, swing)) for toward, path in (("north", north), ("east", east))
    )
    return Overlay(sizes=tuple((size(NAME, key), value) for key, value in sizes.items()), winds=winds)


def _wind(signals: Signals, sizes: Mapping[str, float]) -> tuple[Array, Array, Array]:
    swing = np.sin(2.0 * pi * elapsed(signals) / sizes["period_s"])
    return sizes["north_mps"] * swing, sizes["east_mps"] * swing, np.zeros_like(swing)


WIND_OSCILLATION = AirEffect(
    name=NAME,
    family="air",
    acts_on="air",
    parameters=PARAMETERS,
    source="Holton 2004, Dynamic Meteorology: trapped lee waves of 5 to 25 km, met in minutes of flight",
    what="The wind oscillates during the flight.",
    shows_in=TURNING,  # each circle measures the wind anew
    variant_of="wind_drift",
    build=_build,
    wind=_wind,
)
