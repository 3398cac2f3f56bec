"""A line whose lag grows with height, in proportion to viscosity over static pressure."""

from collections.abc import Mapping

import numpy as np

from pitotbench import air
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import Excitation
from pitotbench.effects.response import first_order_varying
from pitotbench.effects.signals import Signals


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    static = signals["static_pressure"]
    temperature = air.standard_temperature(air.pressure_altitude(static))
    # Relative to sea level; the viscosity of air rises nearly as temperature to the power of 0.75.
    viscosity = (temperature / air.SEA_LEVEL_TEMPERATURE) ** 0.75
    lag = np.asarray(sizes["sea_level_lag_s"] * viscosity * air.SEA_LEVEL_PRESSURE / static)
    total = first_order_varying(signals, signals["impact_pressure"] + static, lag)
    return signals.with_channels(impact_pressure=total - static)


HEIGHT_DEPENDENT_LAG = SensorEffect(
    name="height_dependent_lag",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("sea_level_lag_s", 0.35, 0.01, 3.0, "time constant of the line at sea level"),),
    source="Gracey 1980, NASA RP-1046, pressure-system lag: time constant as viscosity over pressure",
    what="The total-pressure line is late, and later the higher the airplane flies.",
    shows_in=Excitation(("rapid_decel",), "the same decelerations at two heights some 3,000 m apart"),
    variant_of="pitot_lag",
    changes=("impact_pressure",),
    needs=("static_pressure",),
    function=_apply,
)
