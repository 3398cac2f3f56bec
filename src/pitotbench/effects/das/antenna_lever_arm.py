"""A GPS antenna that is not at the center of gravity: it has its own height, and rotation adds to its velocity."""

from collections.abc import Mapping

import numpy as np

from pitotbench.axes import body_to_earth
from pitotbench.effects.effect import Parameter, SensorEffect
from pitotbench.effects.excitation import TURNING
from pitotbench.effects.signals import Signals

ATTITUDE = ("roll", "pitch", "heading", "roll_rate", "pitch_rate", "yaw_rate")


def _apply(signals: Signals, sizes: Mapping[str, float]) -> Signals:
    roll, pitch, heading, p, q, r = (signals[name] for name in ATTITUDE)
    x, y, z = sizes["forward_m"], sizes["right_m"], sizes["down_m"]
    # ω × r in body axes; the log's velocity is in earth axes.
    swing = np.stack([q * z - r * y, r * x - p * z, p * y - q * x])
    added = body_to_earth(swing, roll, pitch, heading)
    names = ("velocity_north", "velocity_east", "velocity_down")
    changed = {name: signals[name] + part for name, part in zip(names, added, strict=True) if name in signals}
    if "altitude" in signals:
        arm = np.repeat(np.array([[x], [y], [z]]), len(signals), axis=1)
        changed["altitude"] = signals["altitude"] - body_to_earth(arm, roll, pitch, heading)[2]
    return signals.with_channels(**changed)


ANTENNA_LEVER_ARM = SensorEffect(
    name="antenna_lever_arm",
    family="das",
    acts_on="sensors",
    parameters=(
        Parameter("forward_m", -3.0, -15.0, 15.0, "antenna ahead of the center of gravity"),
        Parameter("right_m", 1.0, -15.0, 15.0, "antenna right of it"),
        Parameter("down_m", -1.0, -5.0, 5.0, "antenna below it"),
    ),
    source="rigid-body kinematics, v = v_cg + ω × r (Stevens and Lewis 2003, Aircraft Control and Simulation)",
    what="GPS velocity and altitude are those of the antenna, which moves around the center of gravity.",
    shows_in=TURNING,
    changes=("velocity_north", "velocity_east"),
    also=("velocity_down", "altitude"),
    needs=ATTITUDE,
    function=_apply,
)
