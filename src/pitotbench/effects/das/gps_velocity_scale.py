"""A GPS velocity of the wrong scale: a unit, a latitude or a map projection that does not fit."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED
from pitotbench.effects.signals import Signals


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    return signals.with_channels(
        velocity_north=(1.0 + sizes["north"]) * signals["velocity_north"],
        velocity_east=(1.0 + sizes["east"]) * signals["velocity_east"],
    )


GPS_VELOCITY_SCALE = SensorEffect(
    name="gps_velocity_scale",
    family="das",
    acts_on="sensors",
    parameters=(
        Parameter("north", 0.01, -0.2, 0.2, "velocity toward north too large by this share"),
        Parameter("east", 0.01, -0.2, 0.2, "velocity toward east too large by this share"),
    ),
    source="Snyder 1987, Map Projections, USGS PP 1395: scale factors of projections, and the length of a degree "
    "of longitude, which a latitude that is wrong by 1° at 40° changes by 1.5 %",
    what="The horizontal velocity of the GPS has a wrong scale.",
    shows_in=RANGE_OF_AIRSPEED,
    changes=("velocity_north", "velocity_east"),
    function=_apply,
)
