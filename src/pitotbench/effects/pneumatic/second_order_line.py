"""A total-pressure line that oscillates: second-order response of a short, wide line with a large volume."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_AIRSPEED
from pitotbench.effects.response import second_order
from pitotbench.effects.signals import Signals


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    static = signals["static_pressure"]
    total = second_order(signals, signals["impact_pressure"] + static, sizes["lag_s"], sizes["damping"])
    return signals.with_channels(impact_pressure=total - static)


SECOND_ORDER_LINE = SensorEffect(
    name="second_order_line",
    family="pneumatic",
    acts_on="sensors",
    parameters=(
        Parameter("lag_s", 0.4, 0.01, 3.0, "delay of a ramp, 2 damping / natural frequency"),
        Parameter("damping", 0.6, 0.2, 2.0, "damping ratio", shape=True),
    ),
    source="Doebelin 1990, Measurement Systems: pressure line and volume as a second-order system",
    what="The total-pressure line is late and oscillates.",
    shows_in=CHANGING_AIRSPEED,
    variant_of="pitot_lag",
    changes=("impact_pressure",),
    needs=("static_pressure",),
    function=_apply,
)
