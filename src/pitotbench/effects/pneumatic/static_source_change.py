"""A static source that changed since it was calibrated: another curve over airspeed."""

from collections.abc import Mapping

from pitotbench import air
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED
from pitotbench.effects.signals import Signals
from pitotbench.effects.static_source import displaced
from pitotbench.units import KNOT

SLOW, FAST = 100.0 * KNOT, 160.0 * KNOT


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    impact = signals["impact_pressure"]
    share = (air.calibrated_airspeed(impact.clip(min=0.0)) - SLOW) / (FAST - SLOW)
    coefficient = sizes["coefficient_at_100kt"] * (1.0 - share) + sizes["coefficient_at_160kt"] * share
    return displaced(signals, coefficient * impact)


STATIC_SOURCE_CHANGE = SensorEffect(
    name="static_source_change",
    family="pneumatic",
    acts_on="sensors",
    parameters=(
        Parameter("coefficient_at_100kt", 0.010, -0.1, 0.1, "static error over impact pressure at 100 KIAS"),
        Parameter("coefficient_at_160kt", 0.005, -0.1, 0.1, "the same at 160 KIAS; linear in airspeed"),
    ),
    source="Gracey 1980, NASA RP-1046: static-pressure errors of fuselage vents within some 0.05 q_c",
    what="The static port was moved, dented or painted: the position error is another curve.",
    shows_in=RANGE_OF_AIRSPEED,  # its coefficient has one size at each end of the airspeeds
    changes=("impact_pressure", "static_pressure"),
    function=_apply,
)
