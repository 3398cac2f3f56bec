"""A leak between the pitot and the static line: air flows through both, with a pressure drop in each."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import CHANGING_HEIGHT
from pitotbench.effects.signals import Signals


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    impact, lost = signals["impact_pressure"], sizes["fraction"] * signals["impact_pressure"]
    static = signals["static_pressure"] + sizes["static_share"] * lost
    return signals.with_channels(impact_pressure=impact - lost, static_pressure=static)


LINE_LEAK = SensorEffect(
    name="line_leak",
    family="pneumatic",
    acts_on="sensors",
    parameters=(
        Parameter("fraction", 0.02, 0.001, 0.3, "share of the impact pressure that leaks away"),
        Parameter("static_share", 0.5, 0.0, 1.0, "part of the loss that appears in the static line", shape=True),
    ),
    source="laminar flow through three resistances in series, pitot line, leak, static line (Hagen-Poiseuille); "
    "leak tests of FAA AC 43.13-1B, 12-58 and 12-59",
    what="The pitot line leaks into the static line: airspeed low, static pressure high.",
    shows_in=CHANGING_HEIGHT,
    changes=("impact_pressure", "static_pressure"),
    function=_apply,
)
