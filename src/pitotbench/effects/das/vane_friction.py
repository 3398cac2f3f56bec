"""Flow vanes that stick: they follow the flow only once it has turned by more than their friction holds."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import SIDESLIP
from pitotbench.effects.pneumatic.hysteresis import play
from pitotbench.effects.signals import Signals
from pitotbench.units import DEGREE


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    return signals.with_channels(
        angle_of_attack=play(signals["angle_of_attack"], DEGREE * sizes["alpha_deg"]),
        sideslip=play(signals["sideslip"], DEGREE * sizes["sideslip_deg"]),
    )


VANE_FRICTION = SensorEffect(
    name="vane_friction",
    family="das",
    acts_on="sensors",
    parameters=(
        Parameter("alpha_deg", 0.5, 0.02, 10.0, "angle of attack that turns the vane back after a turn-round"),
        Parameter("sideslip_deg", 0.5, 0.02, 10.0, "the same of the sideslip vane"),
    ),
    source="Gracey 1958, NACA TN 4351: vanes and their friction; "
    "the play operator of Krasnosel'skii and Pokrovskii 1989",
    what="The flow vanes stick: dirt, ice or a dry bearing.",
    shows_in=SIDESLIP,
    changes=("angle_of_attack", "sideslip"),
    function=_apply,
)
