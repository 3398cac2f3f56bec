"""Two clocks that differ: the recorder's runs slow or fast against GPS time, so a latency grows with time."""

from collections.abc import Mapping

from pitotbench.channels import numbers_from
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_AIRSPEED
from pitotbench.effects.response import delayed
from pitotbench.effects.signals import Signals


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    late = 1e-6 * sizes["drift_ppm"] * (signals.time - signals.time[0])
    present = [name for name in numbers_from("gps") if name in signals]
    return signals.with_channels(**{name: delayed(signals, signals[name], late) for name in present})


CLOCK_DRIFT = SensorEffect(
    name="clock_drift",
    family="das",
    acts_on="sensors",
    parameters=(Parameter("drift_ppm", 500.0, -5000.0, 5000.0, "GPS data late, a millionth of the time flown"),),
    source="quartz clocks: 20 to 100 ppm by data sheet, some 1,000 ppm for a loaded computer's timer",
    what="The clocks of air data and GPS drift apart during the flight.",
    shows_in=CHANGING_AIRSPEED,
    changes=("velocity_north", "velocity_east"),
    also=("velocity_down", "altitude"),
    function=_apply,
)
