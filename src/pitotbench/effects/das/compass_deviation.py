"""A compass with deviation: the recorded heading errs by an angle that depends on the heading."""

from collections.abc import Callable, Mapping

import numpy as np

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import TURNING
from pitotbench.effects.signals import Signals
from pitotbench.units import DEGREE

SOURCE = (
    "Handbook of Magnetic Compass Adjustment 2004 (NGA, formerly Pub. 226), ch. 5: "
    "B sin ψ + C cos ψ + D sin 2ψ + E cos 2ψ; "
)


def _waves(times: int) -> Callable[[Signals, Mapping[str, float]], Signals]:
    """Return the deviation with so many waves in a full turn."""

    def apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
        angle = times * signals["heading"]
        deviation = sizes["sine_deg"] * np.sin(angle) + sizes["cosine_deg"] * np.cos(angle)
        return signals.with_channels(heading=signals["heading"] + DEGREE * deviation)

    return apply


COMPASS_DEVIATION = SensorEffect(
    name="compass_deviation",
    family="das",
    acts_on="sensors",
    parameters=(
        Parameter("sine_deg", 1.5, -20.0, 20.0, "heading too large on east: coefficient B"),
        Parameter("cosine_deg", -1.0, -20.0, 20.0, "heading too large on north: coefficient C"),
    ),
    source=SOURCE + "14 CFR 25.1327: at most 10° once compensated",
    what="Magnetized parts of the airplane turn the compass: the heading has a semicircular deviation.",
    shows_in=TURNING,
    changes=("heading",),
    function=_waves(1),
)

QUADRANTAL_DEVIATION = SensorEffect(
    name="quadrantal_deviation",
    family="das",
    acts_on="sensors",
    parameters=(
        Parameter("sine_deg", 1.0, -10.0, 10.0, "heading too large on northeast: coefficient D"),
        Parameter("cosine_deg", -0.5, -10.0, 10.0, "heading too large on north and south: coefficient E"),
    ),
    source=SOURCE + "D and E come from induced magnetism",
    what="Soft iron in the airplane bends the earth's field: the heading has a quadrantal deviation.",
    shows_in=TURNING,
    changes=("heading",),
    function=_waves(2),
)
