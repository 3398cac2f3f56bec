"""A static-source error within a narrow band of airspeed, such as a moving flow separation causes."""

from collections.abc import Mapping

import numpy as np

from pitotbench import air
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import STEPS_OF_AIRSPEED
from pitotbench.effects.signals import Signals
from pitotbench.effects.static_source import displaced


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    impact = signals["impact_pressure"]
    away = (air.calibrated_airspeed(impact.clip(min=0.0)) - sizes["center_mps"]) / sizes["width_mps"]
    return displaced(signals, sizes["coefficient"] * np.exp(-0.5 * away**2) * impact)


LOCAL_STATIC_BUMP = SensorEffect(
    name="local_static_bump",
    family="pneumatic",
    acts_on="sensors",
    parameters=(
        Parameter("coefficient", 0.010, -0.1, 0.1, "static error over impact pressure at the band's center"),
        Parameter("center_mps", 65.0, 40.0, 100.0, "indicated airspeed at the center", shape=True),
        Parameter("width_mps", 5.0, 1.0, 30.0, "standard width of the band", shape=True),
    ),
    source="our form: a bump that no model of the table of curves can follow",
    what="The position error has a bump within a band of airspeed.",
    shows_in=STEPS_OF_AIRSPEED,  # the band is narrow, and a fast deceleration blurs it
    variant_of="static_source_change",
    changes=("impact_pressure", "static_pressure"),
    function=_apply,
)
