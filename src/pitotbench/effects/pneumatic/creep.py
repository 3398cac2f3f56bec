"""A transducer whose elastic element creeps: part of each pressure change appears slowly."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_AIRSPEED
from pitotbench.effects.response import first_order
from pitotbench.effects.signals import Signals


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    impact = signals["impact_pressure"]
    behind = impact - first_order(signals, impact, sizes["creep_s"])
    return signals.with_channels(impact_pressure=impact - sizes["fraction"] * behind)


CREEP = SensorEffect(
    name="creep",
    family="pneumatic",
    acts_on="sensors",
    parameters=(
        Parameter("fraction", 0.02, -0.2, 0.3, "part of a change that appears slowly"),
        Parameter("creep_s", 40.0, 1.0, 1000.0, "time constant of that part", shape=True),
    ),
    source="Gracey 1980, NASA RP-1046: drift and after-effect of elastic capsules; one relaxation time",
    what="Readings differ between rising and falling pressure, and the difference depends on the rate.",
    shows_in=CHANGING_AIRSPEED,  # the slow part appears in the legs between the changes
    variant_of="hysteresis",
    changes=("impact_pressure",),
    function=_apply,
)
