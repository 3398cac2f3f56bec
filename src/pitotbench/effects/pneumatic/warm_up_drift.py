"""A transducer whose zero drifts while it warms up, and then stays."""

from collections.abc import Mapping

import numpy as np

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import EARLY_AND_LATE
from pitotbench.effects.signals import Signals


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    warmed = -np.expm1(-(signals.time - signals.time[0]) / sizes["warm_up_s"])
    return signals.with_channels(impact_pressure=signals["impact_pressure"] + sizes["shift_pa"] * warmed)


WARM_UP_DRIFT = SensorEffect(
    name="warm_up_drift",
    family="pneumatic",
    acts_on="sensors",
    parameters=(
        Parameter("shift_pa", 30.0, -300.0, 300.0, "zero shift after the warm-up"),
        Parameter("warm_up_s", 180.0, 5.0, 3600.0, "time constant of the warming", shape=True),
    ),
    source="transducer data sheets: warm-up shift; a lumped thermal mass warms exponentially",
    what="The impact-pressure transducer drifts at first and then settles.",
    shows_in=EARLY_AND_LATE,  # early means from the moment the system is switched on
    variant_of="time_drift",
    changes=("impact_pressure",),
    function=_apply,
)
