"""Flow vanes with a wrong calibration: upwash that was not measured, or a vane that was not set to zero."""

from collections.abc import Callable, Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED, SIDESLIP
from pitotbench.effects.signals import Signals
from pitotbench.units import DEGREE

SOURCE = (
    "Gracey 1958, NACA TN 4351: the flow at a vane is that of the airplane with its upwash; "
    "Haering 1995, NASA TM-104316: scale and offset of flow angles are calibrated in flight"
)


def _read(channel: str) -> Callable[[Signals, Mapping[str, float]], Signals]:
    def apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
        return signals.with_channels(
            **{channel: (1.0 + sizes["scale"]) * signals[channel] + DEGREE * sizes["offset_deg"]}
        )

    return apply


ALPHA_VANE_CALIBRATION = SensorEffect(
    name="alpha_vane_calibration",
    family="das",
    acts_on="sensors",
    parameters=(
        Parameter("scale", 0.1, -0.5, 1.0, "reading too large by this share of the angle: upwash"),
        Parameter("offset_deg", 1.0, -10.0, 10.0, "reading at zero angle of attack"),
    ),
    source=SOURCE,
    what="The vane of the angle of attack has a wrong scale or zero.",
    shows_in=RANGE_OF_AIRSPEED,
    changes=("angle_of_attack",),
    function=_read("angle_of_attack"),
)

SIDESLIP_VANE_CALIBRATION = SensorEffect(
    name="sideslip_vane_calibration",
    family="das",
    acts_on="sensors",
    parameters=(
        Parameter("scale", 0.1, -0.5, 1.0, "reading too large by this share of the angle: sidewash"),
        Parameter("offset_deg", 1.0, -10.0, 10.0, "reading at zero sideslip"),
    ),
    source=SOURCE,
    what="The vane of the sideslip has a wrong scale or zero.",
    shows_in=SIDESLIP,
    changes=("sideslip",),
    function=_read("sideslip"),
)
