"""A transducer or amplifier whose range ends below the speeds flown."""

from collections.abc import Mapping

import numpy as np

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED
from pitotbench.effects.signals import Signals


# Acts after the noise: an amplifier at its limit gives a constant, not noise around it.
def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    return signals.with_channels(impact_pressure=np.minimum(signals["impact_pressure"], sizes["ceiling_pa"]))


SATURATION = SensorEffect(
    name="saturation",
    family="das",
    acts_on="sensors",
    parameters=(Parameter("ceiling_pa", 3500.0, 500.0, 20000.0, "greatest impact pressure; 0 for none"),),
    source="range of the transducer or of its amplifier; 3,500 Pa is 146 KIAS",
    what="Above some airspeed the impact pressure does not rise any more.",
    shows_in=RANGE_OF_AIRSPEED,  # only the highest airspeeds reach the ceiling
    changes=("impact_pressure",),
    after_noise=True,
    function=_apply,
)
