"""A pitot tube that loses total pressure: a burr at its mouth, or inclined flow."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED
from pitotbench.effects.signals import Signals

SOURCE = "Gracey 1980, NASA RP-1046: total-pressure error of tubes with nose shape and inclination"


def _plain(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    return signals.with_channels(impact_pressure=signals["impact_pressure"] * (1.0 - sizes["fraction"]))


def _inclined(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    loss = sizes["loss_per_rad2"] * signals["angle_of_attack"] ** 2
    return signals.with_channels(impact_pressure=signals["impact_pressure"] * (1.0 - loss))


TOTAL_PRESSURE_LOSS = SensorEffect(
    name="total_pressure_loss",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("fraction", 0.01, -0.05, 0.15, "share of the impact pressure that is lost"),),
    source=SOURCE,
    what="The pitot tube reads too low at all speeds; the static pressure is right.",
    # A loss is in proportion to the impact pressure; GPS heights show that the static pressure is right.
    shows_in=RANGE_OF_AIRSPEED,
    changes=("impact_pressure",),
    function=_plain,
)

INCLINED_PITOT_LOSS = SensorEffect(
    name="inclined_pitot_loss",
    family="pneumatic",
    acts_on="sensors",
    parameters=(Parameter("loss_per_rad2", 1.0, -5.0, 10.0, "loss over impact pressure per square radian"),),
    source=SOURCE,
    what="The pitot tube reads too low at high angles of attack.",
    shows_in=RANGE_OF_AIRSPEED,  # the angle of attack is largest at the lowest airspeed
    variant_of="total_pressure_loss",
    changes=("impact_pressure",),
    needs=("angle_of_attack",),
    function=_inclined,
)
