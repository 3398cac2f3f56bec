"""A word that is too short for its range: pressures are recorded in steps."""

from collections.abc import Mapping

import numpy as np

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_AIRSPEED
from pitotbench.effects.signals import Signals

PRESSURES = ("impact_pressure", "static_pressure")


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    step = sizes["step_pa"]
    return signals.with_channels(**{name: np.rint(signals[name] / step) * step for name in PRESSURES})


QUANTIZATION = SensorEffect(
    name="quantization",
    family="das",
    acts_on="sensors",
    parameters=(Parameter("step_pa", 40.0, 1.0, 500.0, "step of both pressures"),),
    source="Widrow and Kollár 2008, Quantization Noise: a step q adds q²/12; 34 Pa is 12 bits over 138 kPa",
    what="The pressures are stored in coarse steps.",
    shows_in=CHANGING_AIRSPEED,  # a pressure that changes crosses many steps
    changes=PRESSURES,
    after_noise=True,
    function=_apply,
)
