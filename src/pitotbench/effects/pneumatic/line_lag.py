"""Lag of a long thin pressure line: first order, one time constant for each line."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_AIRSPEED, CHANGING_HEIGHT
from pitotbench.effects.response import first_order
from pitotbench.effects.signals import Signals

SOURCE = "Gracey 1980, NASA RP-1046, ch. on pressure-system lag: first-order line"
PRESSURES = ("impact_pressure", "static_pressure")


def _pitot(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    # The line carries the total pressure; the differential transducer subtracts a static pressure that is not late.
    static = signals["static_pressure"]
    total = first_order(signals, signals["impact_pressure"] + static, sizes["lag_s"])
    return signals.with_channels(impact_pressure=total - static)


def _static(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    # Both transducers are connected to this line, so its delay appears in both, with opposite signs.
    static = signals["static_pressure"]
    late = first_order(signals, static, sizes["lag_s"])
    return signals.with_channels(static_pressure=late, impact_pressure=signals["impact_pressure"] + static - late)


PITOT_LAG = SensorEffect(
    name="pitot_lag",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("lag_s", 0.4, 0.01, 3.0, "time constant of the total-pressure line"),),
    source=SOURCE,
    what="The total-pressure line is long or thin: indicated airspeed follows late.",
    shows_in=CHANGING_AIRSPEED,
    changes=("impact_pressure",),
    needs=("static_pressure",),
    function=_pitot,
)

STATIC_LAG = SensorEffect(
    name="static_lag",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("lag_s", 0.6, 0.01, 5.0, "time constant of the static-pressure line"),),
    source=SOURCE,
    what="The static-pressure line is long or thin: altitude follows late, and airspeed errs in climbs.",
    shows_in=CHANGING_HEIGHT,
    changes=PRESSURES,
    function=_static,
)
