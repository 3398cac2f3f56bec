"""A transducer that reads differently at rising and falling pressure: the play operator."""

from collections.abc import Mapping
from itertools import accumulate

import numpy as np

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_AIRSPEED, CHANGING_HEIGHT
from pitotbench.effects.signals import Signals
from pitotbench.units import Array

SOURCE = "Krasnosel'skii and Pokrovskii 1989, Systems with Hysteresis; data sheets: 0.1 % of full scale"


def play(values: Array, width: float) -> Array:
    """Apply the play operator to values, (n,): the output follows half a width [same unit] behind the input.

    Where the input turns back, the output stays until the input has moved by a whole width.
    """
    half = 0.5 * width
    followed = accumulate(values.tolist(), lambda held, u: min(max(held, u - half), u + half))
    return np.fromiter(followed, dtype=np.float64, count=len(values))


def _impact(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    return signals.with_channels(impact_pressure=play(signals["impact_pressure"], sizes["width_pa"]))


def _static(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    return signals.with_channels(static_pressure=play(signals["static_pressure"], sizes["width_pa"]))


HYSTERESIS = SensorEffect(
    name="hysteresis",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("width_pa", 25.0, 1.0, 300.0, "reading at falling minus reading at rising pressure"),),
    source=SOURCE,
    what="Decelerations read higher than accelerations at the same speed.",
    shows_in=CHANGING_AIRSPEED,
    changes=("impact_pressure",),
    function=_impact,
)

STATIC_HYSTERESIS = SensorEffect(
    name="static_hysteresis",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("width_pa", 100.0, 5.0, 1500.0, "reading at falling minus reading at rising pressure"),),
    source=SOURCE,
    what="The static pressure reads higher in a climb than in a descent at the same height.",
    shows_in=CHANGING_HEIGHT,
    changes=("static_pressure",),
    function=_static,
)
