"""A wind that changes with height."""

from collections.abc import Mapping

import numpy as np

from pitotbench.effects.effect import AirEffect, Parameter
from pitotbench.effects.excitation import CHANGING_HEIGHT
from pitotbench.effects.expression import difference, product, size
from pitotbench.effects.overlay import Baseline, Overlay, WindTerm
from pitotbench.effects.signals import Signals
from pitotbench.units import FOOT, Array

NAME = "wind_shear"
KILOMETER = 1000.0  # m
PARAMETERS = (
    Parameter("north_mps_per_km", 4.0, -50.0, 50.0, "growth of the wind toward north with height"),
    Parameter("east_mps_per_km", 6.0, -50.0, 50.0, "growth of the wind toward east with height"),
    Parameter("reference_m", 1828.8, 0.0, 15000.0, "height of the steady wind", shape=True),
)


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    north, east, reference = (size(NAME, p.name) for p in PARAMETERS)
    above = difference(product("position/h-sl-ft", FOOT), reference)
    winds = tuple(
        WindTerm(toward, product(path, above, 1.0 / (KILOMETER * FOOT)))
        for toward, path in (("north", north), ("east", east))
    )
    return Overlay(sizes=tuple((size(NAME, key), value) for key, value in sizes.items()), winds=winds)


def _wind(signals: Signals, sizes: Mapping[str, float]) -> tuple[Array, Array, Array]:
    signals.require(NAME, ("altitude",))
    above = (signals["altitude"] - sizes["reference_m"]) / KILOMETER
    return sizes["north_mps_per_km"] * above, sizes["east_mps_per_km"] * above, np.zeros_like(above)


WIND_SHEAR = AirEffect(
    name=NAME,
    family="air",
    acts_on="air",
    parameters=PARAMETERS,
    source="thermal wind, a few m/s a kilometer (Holton 2004, Dynamic Meteorology); more below inversions",
    what="The wind changes with height.",
    shows_in=CHANGING_HEIGHT,
    build=_build,
    wind=_wind,
)
