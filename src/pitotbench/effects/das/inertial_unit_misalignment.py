"""An inertial unit that is not aligned with the airplane: attitude, rates and forces are in its own axes."""

from collections.abc import Mapping

import numpy as np

from pitotbench.axes import body_to_earth
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import TURNING
from pitotbench.effects.signals import Signals
from pitotbench.units import DEGREE, Array

ATTITUDE = ("roll", "pitch", "heading")
RATES = ("roll_rate", "pitch_rate", "yaw_rate")
FORCES = ("specific_force_x", "specific_force_y", "specific_force_z")


def _unit_axes(sizes: Mapping[str, float]) -> Array:
    """Return the axes of the unit, one a row, in the axes of the airplane."""
    angles = (DEGREE * sizes[name] for name in ("roll_deg", "pitch_deg", "yaw_deg"))
    return body_to_earth(np.eye(3), *(np.full(3, angle) for angle in angles)).T


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    axes = _unit_axes(sizes)
    roll, pitch, heading = (signals[name] for name in ATTITUDE)
    forward, right, down = (
        body_to_earth(np.repeat(axis[:, None], len(signals), axis=1), roll, pitch, heading) for axis in axes
    )
    turned = np.arctan2(forward[1], forward[0]) - heading
    changed = {
        "roll": np.arctan2(right[2], down[2]),
        "pitch": -np.arcsin(np.clip(forward[2], -1.0, 1.0)),
        # The heading keeps its count of full turns.
        "heading": heading + np.mod(turned + np.pi, 2.0 * np.pi) - np.pi,
    }
    for names in (RATES, FORCES):
        if all(name in signals for name in names):
            changed |= dict(zip(names, axes @ np.stack([signals[name] for name in names]), strict=True))
    return signals.with_channels(**changed)


INERTIAL_UNIT_MISALIGNMENT = SensorEffect(
    name="inertial_unit_misalignment",
    family="das",
    acts_on="sensors",
    parameters=(
        Parameter("roll_deg", 1.0, -15.0, 15.0, "unit mounted right wing down"),
        Parameter("pitch_deg", 1.0, -15.0, 15.0, "unit mounted nose up"),
        Parameter("yaw_deg", 1.0, -15.0, 15.0, "unit mounted nose right"),
    ),
    source="rotation of axes (Stevens and Lewis 2003, Aircraft Control and Simulation, §1.3); "
    "1° is a mount that was leveled by eye (estimate)",
    what="The inertial unit is not aligned with the airplane.",
    shows_in=TURNING,
    changes=ATTITUDE,
    also=(*RATES, *FORCES),
    function=_apply,
)
