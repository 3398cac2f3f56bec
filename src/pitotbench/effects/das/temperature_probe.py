"""Errors of the temperature probe: it measures less than the whole ram rise, or reads too warm."""

from collections.abc import Mapping

import numpy as np

from pitotbench import air
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import TEMPERATURE
from pitotbench.effects.signals import Signals

SOURCE = "Trenkle and Reinhardt 1973, AGARDograph 160 vol. 2: recovery 0.6 to 0.99; probe errors of some kelvin"


def _recovery(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    # Noise can make the impact pressure slightly negative at rest, where the Mach number is zero.
    mach = air.mach_from_impact_pressure(signals["impact_pressure"].clip(min=0.0), signals["static_pressure"])
    static = air.air_temperature(signals["total_temperature"], mach)
    return signals.with_channels(total_temperature=air.total_temperature(static, mach, 1.0 - sizes["deficit"]))


def _bias(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    return signals.with_channels(total_temperature=np.asarray(signals["total_temperature"] + sizes["bias_k"]))


RECOVERY_DEFICIT = SensorEffect(
    name="recovery_deficit",
    family="das",
    acts_on="sensors",
    parameters=(Parameter("deficit", 0.2, -0.2, 1.0, "one minus the recovery factor, against full recovery"),),
    source=SOURCE,
    what="The temperature probe measures only part of the ram rise.",
    shows_in=TEMPERATURE,
    changes=("total_temperature",),
    needs=("impact_pressure", "static_pressure"),
    function=_recovery,
)

TEMPERATURE_BIAS = SensorEffect(
    name="temperature_bias",
    family="das",
    acts_on="sensors",
    parameters=(Parameter("bias_k", 2.5, -15.0, 15.0, "reading above the probe's temperature"),),
    source=SOURCE,
    what="The temperature probe reads too warm or too cold by a constant.",
    shows_in=TEMPERATURE,
    changes=("total_temperature",),
    function=_bias,
)
