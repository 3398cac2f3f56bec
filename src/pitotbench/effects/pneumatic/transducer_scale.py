"""Transducers of the wrong scale: the reading is in proportion to the pressure, by a wrong factor."""

from collections.abc import Callable, Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_HEIGHT, RANGE_OF_AIRSPEED
from pitotbench.effects.signals import Signals

SOURCE = "transducer data sheets: span errors of 0.05 to 0.5 % (classes, not one maker)"


def _times(channel: str) -> Callable[[Signals, Mapping[str, float]], Signals]:
    def apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
        return signals.with_channels(**{channel: (1.0 + sizes["scale"]) * signals[channel]})

    return apply


IMPACT_PRESSURE_SCALE = SensorEffect(
    name="impact_pressure_scale",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("scale", 0.005, -0.1, 0.1, "impact pressure too large by this share"),),
    source=SOURCE,
    what="The impact-pressure transducer has a wrong scale; in a log it is a total-pressure loss.",
    shows_in=RANGE_OF_AIRSPEED,
    changes=("impact_pressure",),
    function=_times("impact_pressure"),
)

STATIC_PRESSURE_SCALE = SensorEffect(
    name="static_pressure_scale",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("scale", 0.002, -0.05, 0.05, "static pressure too large by this share"),),
    source=SOURCE,
    what="The static-pressure transducer has a wrong scale.",
    shows_in=CHANGING_HEIGHT,
    changes=("static_pressure",),
    function=_times("static_pressure"),
)
