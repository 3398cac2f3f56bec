"""Transducers that do not read zero at zero pressure."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_HEIGHT, RANGE_OF_AIRSPEED
from pitotbench.effects.signals import Signals

SOURCE = "transducer data sheets: zero error up to some 0.1 % of full scale (13.8 kPa impact, 129 kPa static)"


def _impact(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    return signals.with_channels(impact_pressure=signals["impact_pressure"] + sizes["offset_pa"])


def _static(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    return signals.with_channels(static_pressure=signals["static_pressure"] + sizes["offset_pa"])


IMPACT_ZERO_OFFSET = SensorEffect(
    name="impact_zero_offset",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("offset_pa", 15.0, -150.0, 150.0, "reading at zero impact pressure"),),
    source=SOURCE,
    what="The impact-pressure transducer does not read zero at rest.",
    shows_in=RANGE_OF_AIRSPEED,  # a constant is the largest share of the impact pressure at the lowest airspeed
    changes=("impact_pressure",),
    function=_impact,
)

STATIC_ZERO_OFFSET = SensorEffect(
    name="static_zero_offset",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("offset_pa", 80.0, -500.0, 500.0, "reading above the true static pressure"),),
    source=SOURCE,
    what="The static-pressure transducer reads too high or too low by a constant.",
    shows_in=CHANGING_HEIGHT,
    changes=("static_pressure",),
    function=_static,
)
