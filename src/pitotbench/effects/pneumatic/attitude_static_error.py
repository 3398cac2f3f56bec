"""A static source that depends on the direction of the flow: errors with angle of attack or sideslip."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED, SIDESLIP
from pitotbench.effects.signals import Signals
from pitotbench.effects.static_source import displaced

SOURCE = "Gracey 1980, NASA RP-1046: static-pressure error with angle of attack and yaw"
PRESSURES = ("impact_pressure", "static_pressure")


def _alpha(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    return displaced(signals, sizes["slope_per_rad"] * signals["angle_of_attack"] * signals["impact_pressure"])


def _sideslip(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    beta = signals["sideslip"]
    coefficient = sizes["slope_per_rad"] * beta + sizes["curvature_per_rad2"] * beta**2
    return displaced(signals, coefficient * signals["impact_pressure"])


ALPHA_STATIC_ERROR = SensorEffect(
    name="alpha_static_error",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("slope_per_rad", 0.15, -1.0, 1.0, "static error over impact pressure per radian"),),
    source=SOURCE,
    what="The static-pressure error depends on angle of attack, so it changes in turns and with weight.",
    shows_in=RANGE_OF_AIRSPEED,
    changes=PRESSURES,
    needs=("angle_of_attack",),
    function=_alpha,
)

SIDESLIP_STATIC_ERROR = SensorEffect(
    name="sideslip_static_error",
    family="pneumatic",
    acts_on="sensors",
    parameters=(
        Parameter("slope_per_rad", 0.10, -2.0, 2.0, "static error over impact pressure per radian: one port only"),
        Parameter("curvature_per_rad2", -1.5, -10.0, 10.0, "the same per square radian: two joined ports keep it"),
    ),
    source=SOURCE,
    what="The static pressure has an error in sideslip.",
    shows_in=SIDESLIP,
    changes=PRESSURES,
    needs=("sideslip",),
    function=_sideslip,
)
