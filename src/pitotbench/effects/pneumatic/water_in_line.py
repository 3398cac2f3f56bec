"""Water in the pitot line: its weight adds pressure with acceleration and pitch, and it restricts the line."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_AIRSPEED
from pitotbench.effects.response import first_order
from pitotbench.effects.signals import Signals

WATER = 1000.0  # kg/m³


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    static = signals["static_pressure"]
    total = first_order(signals, signals["impact_pressure"] + static, sizes["lag_s"])
    head = WATER * sizes["column_m"] * signals["specific_force_x"]
    return signals.with_channels(impact_pressure=total - static - head)


WATER_IN_LINE = SensorEffect(
    name="water_in_line",
    family="pneumatic",
    acts_on="sensors",
    parameters=(
        Parameter(
            "column_m", 0.03, -0.3, 0.3, "length of the water column along the airplane, tube ahead", defining=True
        ),
        Parameter("lag_s", 0.8, 0.0, 20.0, "time constant of the restricted line"),
    ),
    source="hydrostatics, density times specific force times length; Gracey 1980, NASA RP-1046: water in lines",
    what="Water stands in the pitot line: the reading is late and changes with pitch and acceleration.",
    shows_in=CHANGING_AIRSPEED,
    changes=("impact_pressure",),
    needs=("static_pressure", "specific_force_x"),
    function=_apply,
)
