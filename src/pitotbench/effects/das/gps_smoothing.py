"""A receiver that filters its velocity: late in a ramp, and rounded where the velocity changes direction."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_AIRSPEED
from pitotbench.effects.response import first_order
from pitotbench.effects.signals import Signals

VELOCITIES = ("velocity_north", "velocity_east", "velocity_down")


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    present = [name for name in VELOCITIES if name in signals]
    return signals.with_channels(**{name: first_order(signals, signals[name], sizes["lag_s"]) for name in present})


GPS_SMOOTHING = SensorEffect(
    name="gps_smoothing",
    family="das",
    acts_on="sensors",
    parameters=(Parameter("lag_s", 0.3, 0.01, 3.0, "time constant of the receiver's filter"),),
    source="receivers' low-dynamics navigation filters; first-order form (estimate)",
    what="The receiver smooths its velocity and so delays it.",
    shows_in=CHANGING_AIRSPEED,
    variant_of="gps_latency",
    changes=VELOCITIES[:2],
    also=VELOCITIES[2:],
    function=_apply,
)
