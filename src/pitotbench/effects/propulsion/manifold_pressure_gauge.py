"""Manifold-pressure gauges that read wrong. The power stays: only the recorded pressure changes."""

from collections.abc import Mapping

from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import POWER
from pitotbench.effects.signals import Signals
from pitotbench.units import INCH_OF_MERCURY

CHANNELS = ("manifold_pressure_left", "manifold_pressure_right")


def _offset(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    errors = (sizes["left_inhg"], sizes["right_inhg"])
    read = {name: signals[name] + e * INCH_OF_MERCURY for name, e in zip(CHANNELS, errors, strict=True)}
    return signals.with_channels(**read)


def _scale(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    errors = (sizes["left"], sizes["right"])
    return signals.with_channels(
        **{name: (1.0 + e) * signals[name] for name, e in zip(CHANNELS, errors, strict=True)}
    )


MANIFOLD_PRESSURE_GAUGE = SensorEffect(
    name="manifold_pressure_gauge",
    family="propulsion",
    acts_on="sensors",
    parameters=(
        Parameter("left_inhg", 0.6, -4.0, 4.0, "left gauge reads too high"),
        Parameter("right_inhg", -0.4, -4.0, 4.0, "right gauge reads too high"),
    ),
    source="aircraft gauges are read to some 0.2 inHg and err by as much again (estimate)",
    what="The recorded manifold pressure is not that of the engine.",
    shows_in=POWER,
    changes=CHANNELS,
    function=_offset,
)

MANIFOLD_PRESSURE_SCALE = SensorEffect(
    name="manifold_pressure_scale",
    family="propulsion",
    acts_on="sensors",
    parameters=(
        Parameter("left", 0.02, -0.2, 0.2, "left gauge reads too high by this share"),
        Parameter("right", -0.015, -0.2, 0.2, "right gauge reads too high by this share"),
    ),
    source="standard of manifold-pressure instruments: SAE AS8042, 1985; 2 % is 0.6 inHg at 30 inHg (estimate)",
    what="The scale of the manifold-pressure gauges is wrong.",
    shows_in=POWER,
    variant_of="manifold_pressure_gauge",
    changes=CHANNELS,
    function=_scale,
)
