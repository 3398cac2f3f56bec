"""Air data that are stamped when they arrive: one delay of the bus for all of them."""

from collections.abc import Mapping

from pitotbench.effects.das.air_data import AIR_DATA
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_AIRSPEED
from pitotbench.effects.response import delayed
from pitotbench.effects.signals import Signals


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    present = [name for name in AIR_DATA if name in signals]
    return signals.with_channels(**{name: delayed(signals, signals[name], sizes["latency_s"]) for name in present})


AIR_DATA_LATENCY = SensorEffect(
    name="air_data_latency",
    family="das",
    acts_on="sensors",
    parameters=(Parameter("latency_s", 0.3, 0.01, 3.0, "time by which pressures and temperature are late"),),
    source="Martos, Kiszely and Foster 2011, §II.C: time alignment of air data and GPS",
    what="Pressures and temperature are recorded late against GPS and attitude.",
    shows_in=CHANGING_AIRSPEED,
    changes=AIR_DATA[:2],
    also=AIR_DATA[2:],
    function=_apply,
)
