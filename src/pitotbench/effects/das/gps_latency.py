"""A GPS solution that is stamped when it arrives, not when it was true."""

from collections.abc import Mapping

from pitotbench.channels import numbers_from
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_AIRSPEED
from pitotbench.effects.response import delayed
from pitotbench.effects.signals import Signals


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    present = [name for name in numbers_from("gps") if name in signals]
    late = {name: delayed(signals, signals[name], sizes["latency_s"]) for name in present}
    return signals.with_channels(**late)


GPS_LATENCY = SensorEffect(
    name="gps_latency",
    family="das",
    acts_on="sensors",
    parameters=(Parameter("latency_s", 0.3, 0.01, 3.0, "time by which GPS velocity and altitude are late"),),
    source="Martos, Kiszely and Foster 2011, §II.C: time alignment of air data and GPS",
    what="GPS velocity and altitude are recorded late against the air data.",
    shows_in=CHANGING_AIRSPEED,
    changes=("velocity_north", "velocity_east"),
    also=("velocity_down", "altitude"),
    function=_apply,
)
