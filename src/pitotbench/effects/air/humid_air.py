"""Humid air: it is as light as drier air that is warmer, and the thermometer reads less than that warmth."""

from collections.abc import Mapping

import numpy as np

from pitotbench import air
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import TEMPERATURE
from pitotbench.effects.signals import Signals
from pitotbench.units import Array, Kelvin, Pascal

FREEZING = 273.15  # K
LIGHTER = 0.378  # 1 − molar mass of water over that of dry air, 1 − 18.015/28.964
ROUNDS = 4  # of solving for the temperature that has this virtual temperature; each gains a digit or more


def saturation_pressure(temperature: Kelvin) -> Pascal:
    """Return the saturation pressure of water vapor [Pa] at a temperature [K], to 0.3 % from -35 to 35 °C.

    Source: Bolton 1980, Monthly Weather Review 108, eq. 10.
    """
    celsius = temperature - FREEZING
    return np.asarray(611.2 * np.exp(17.67 * celsius / (celsius + 243.5)))


def _dry_bulb(virtual: Kelvin, pressure: Pascal, humidity: float) -> Array:
    """Return the temperature [K] of air of a virtual temperature, T_v = T/(1 − 0.378 e/p)."""
    temperature = virtual
    for _ in range(ROUNDS):
        vapor = humidity * saturation_pressure(temperature)
        temperature = virtual * (1.0 - LIGHTER * vapor / pressure)
    return temperature


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    pressure = signals["static_pressure"]
    mach = air.mach_from_impact_pressure(signals["impact_pressure"].clip(min=0.0), pressure)
    virtual = air.air_temperature(signals["total_temperature"], mach)
    read = air.total_temperature(_dry_bulb(virtual, pressure, sizes["relative_humidity"]), mach)
    return signals.with_channels(total_temperature=read)


HUMID_AIR = SensorEffect(
    name="humid_air",
    family="air",
    acts_on="sensors",
    parameters=(Parameter("relative_humidity", 0.7, 0.02, 1.0, "vapor pressure over that of saturation"),),
    source="Bolton 1980, Monthly Weather Review 108, eq. 10: saturation pressure; T_v = T/(1 − 0.378 e/p)",
    what="The air is humid: the temperature of the case is the virtual one, and the probe reads less.",
    shows_in=TEMPERATURE,
    changes=("total_temperature",),
    needs=("impact_pressure", "static_pressure"),
    function=_apply,
)
