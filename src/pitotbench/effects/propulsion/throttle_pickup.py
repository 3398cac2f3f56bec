"""Throttle pickups that are not linear: right at both ends of the travel, wrong between them."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import POWER
from pitotbench.effects.signals import Signals

CHANNELS = ("throttle_left", "throttle_right")


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    bends = (sizes["left"], sizes["right"])
    read = {
        name: signals[name] + 4.0 * bend * signals[name] * (1.0 - signals[name])
        for name, bend in zip(CHANNELS, bends, strict=True)
    }
    return signals.with_channels(**read)


THROTTLE_PICKUP = SensorEffect(
    name="throttle_pickup",
    family="propulsion",
    acts_on="sensors",
    parameters=(
        Parameter("left", 0.03, -0.2, 0.2, "left throttle reads too far open at half travel, share of the travel"),
        Parameter("right", -0.02, -0.2, 0.2, "the same of the right throttle"),
    ),
    source="our form, a parabola; Doebelin 1990, Measurement Systems: a load on a potentiometer bends its reading "
    "between the ends",
    what="The throttle pickups bend: the recorded throttles err between idle and full.",
    shows_in=POWER,
    changes=CHANNELS,
    function=_apply,
)
