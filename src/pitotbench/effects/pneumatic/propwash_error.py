"""The slipstream at the static port: an error that grows with engine power and falls with airspeed."""

from collections.abc import Mapping

import numpy as np

from pitotbench import air
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import POWER
from pitotbench.effects.signals import Signals
from pitotbench.effects.static_source import displaced
from pitotbench.units import INCH_OF_MERCURY, KNOT, SUFFIXES, Array

ENGINES = ("left", "right")
FULL = 40.0 * INCH_OF_MERCURY * 2575.0 * SUFFIXES["rpm"].factor  # Pa rad/s, rated power of the class
REFERENCE_SPEED = 130.0 * KNOT
SLOWEST = 40.0 * KNOT  # below it the error stays: power over speed would grow without limit


def power_index(signals: Signals) -> Array:
    """Return manifold pressure times propeller speed over that at rated power [-], (n,), mean of the engines."""
    each = [signals[f"manifold_pressure_{side}"] * signals[f"propeller_speed_{side}"] for side in ENGINES]
    return np.asarray(sum(each) / (len(each) * FULL))


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    speed = np.maximum(air.calibrated_airspeed(signals["impact_pressure"].clip(min=0.0)), SLOWEST)
    # Thrust is power over speed, and the slipstream's pressure is proportional to thrust.
    return displaced(signals, sizes["pressure_pa"] * power_index(signals) * REFERENCE_SPEED / speed)


PROPWASH_ERROR = SensorEffect(
    name="propwash_error",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("pressure_pa", 40.0, -300.0, 300.0, "static error at rated power and 130 KIAS"),),
    source="McCormick 1995, Aerodynamics, Aeronautics and Flight Mechanics, momentum theory: the slipstream's "
    "pressure goes with thrust over disk area, thrust with power over speed",
    what="The static pressure has an error that depends on engine power.",
    shows_in=POWER,
    changes=("impact_pressure", "static_pressure"),
    needs=tuple(f"{name}_{side}" for name in ("manifold_pressure", "propeller_speed") for side in ENGINES),
    function=_apply,
)
