"""Lost frames of air data, which the recorder fills with the last good one."""

from collections.abc import Mapping

import numpy as np

from pitotbench.effects.das.air_data import AIR_DATA
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_AIRSPEED
from pitotbench.effects.signals import Signals


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    # Bursts begin at random, so often that the share of lost rows comes out right. The first row of a stretch is
    # never lost: the recorder has no earlier value to repeat.
    draw = np.random.default_rng(int(sizes["seed"]))
    start, lost = sizes["fraction"] / sizes["burst_rows"], np.zeros(len(signals), dtype=np.bool_)
    begun = np.flatnonzero(draw.random(len(signals)) < start)
    for length in range(int(sizes["burst_rows"])):
        lost[np.minimum(begun + length, len(signals) - 1)] = True
    lost[[part.start for part in signals.stretches()]] = False
    source = np.maximum.accumulate(np.where(lost, 0, np.arange(len(signals))))
    return signals.with_channels(**{name: signals[name][source] for name in AIR_DATA if name in signals})


DROPPED_SAMPLES = SensorEffect(
    name="dropped_samples",
    family="das",
    acts_on="sensors",
    parameters=(
        Parameter("fraction", 0.05, 0.001, 0.5, "share of the rows that is lost"),
        Parameter("burst_rows", 4.0, 1.0, 200.0, "rows lost at once", shape=True),
        Parameter("seed", 1.0, 0.0, 1e6, "which rows are lost", shape=True),
    ),
    source="Gilbert 1960, Bell System Technical Journal 39: losses come in bursts",
    what="Some rows of air data are lost; the recorder repeats the last good one.",
    shows_in=CHANGING_AIRSPEED,  # a row that repeats shows only while the pressure changes
    changes=("impact_pressure", "static_pressure"),
    also=("total_temperature",),
    after_noise=True,
    function=_apply,
)
