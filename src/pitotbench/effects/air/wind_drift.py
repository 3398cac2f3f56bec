"""A wind that changes steadily during the flight."""

from collections.abc import Mapping

import numpy as np

from pitotbench.effects.air.recorded_time import ELAPSED, elapsed
from pitotbench.effects.effect import AirEffect, Parameter
from pitotbench.effects.excitation import TURNING
from pitotbench.effects.expression import product, size
from pitotbench.effects.overlay import Baseline, Overlay, WindTerm
from pitotbench.effects.signals import Signals
from pitotbench.units import FOOT, Array

NAME = "wind_drift"
MINUTE = 60.0  # s
PARAMETERS = (
    Parameter("north_mps_per_min", 0.15, -2.0, 2.0, "change of the wind toward north, per minute"),
    Parameter("east_mps_per_min", -0.10, -2.0, 2.0, "change of the wind toward east, per minute"),
)


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    paths = [size(NAME, p.name) for p in PARAMETERS]
    winds = [
        WindTerm(toward, product(path, 1.0 / (MINUTE * FOOT), ELAPSED))
        for toward, path in zip(("north", "east"), paths, strict=True)
    ]
    return Overlay(sizes=tuple((size(NAME, key), value) for key, value in sizes.items()), winds=tuple(winds))


def _wind(signals: Signals, sizes: Mapping[str, float]) -> tuple[Array, Array, Array]:
    minutes = elapsed(signals) / MINUTE
    return sizes["north_mps_per_min"] * minutes, sizes["east_mps_per_min"] * minutes, np.zeros_like(minutes)


WIND_DRIFT = AirEffect(
    name=NAME,
    family="air",
    acts_on="air",
    parameters=PARAMETERS,
    source="Martos, Kiszely and Foster 2011: the methods take the wind as constant; hourly changes of 2 to 5 m/s "
    "are usual in soundings (estimate)",
    what="The wind changes during the flight.",
    shows_in=TURNING,
    build=_build,
    wind=_wind,
)
