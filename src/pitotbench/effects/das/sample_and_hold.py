"""A bus that delivers new air data less often than the recorder writes rows: values repeat."""

from collections.abc import Mapping

import numpy as np

from pitotbench.effects.das.air_data import AIR_DATA
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_AIRSPEED
from pitotbench.effects.signals import Signals

_SLACK = 1e-6  # periods: a row this close to a refresh has it


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    source = np.arange(len(signals))
    for part in signals.stretches():
        time = signals.time[part]
        frame = np.floor((time - time[0]) / sizes["period_s"] + _SLACK)
        source[part] = part.start + np.searchsorted(frame, frame)  # the first row of each frame
    return signals.with_channels(**{name: signals[name][source] for name in AIR_DATA if name in signals})


SAMPLE_AND_HOLD = SensorEffect(
    name="sample_and_hold",
    family="das",
    acts_on="sensors",
    parameters=(Parameter("period_s", 0.25, 0.02, 5.0, "time between new values"),),
    source="Martos, Kiszely and Foster 2011, §II.C: data systems of several rates on one time base",
    what="Air data refresh more slowly than they are recorded: each value repeats.",
    shows_in=CHANGING_AIRSPEED,  # a value that repeats shows only while the pressure changes
    changes=("impact_pressure", "static_pressure"),
    also=("total_temperature",),
    after_noise=True,
    function=_apply,
)
