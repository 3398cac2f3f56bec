"""Trim or rigging: a constant moment about each axis that the surfaces must hold."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED
from pitotbench.effects.expression import product, size
from pitotbench.effects.overlay import AxisFunction, Baseline, Overlay

NAME = "trim_offset"
PARAMETERS = (
    Parameter("pitch_coefficient", 0.015, -0.1, 0.1, "added pitching-moment coefficient, nose up"),
    Parameter("roll_coefficient", 0.002, -0.02, 0.02, "added rolling-moment coefficient, right"),
    Parameter("yaw_coefficient", 0.002, -0.02, 0.02, "added yawing-moment coefficient, nose right"),
)
_LENGTHS = {"PITCH": "metrics/cbarw-ft", "ROLL": "metrics/bw-ft", "YAW": "metrics/bw-ft"}


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    # Moment = dynamic pressure × wing area × reference length × coefficient, as in the aircraft's file.
    paths = [size(NAME, p.name) for p in PARAMETERS]
    moments = [
        AxisFunction(axis, product("aero/qbar-psf", "metrics/Sw-sqft", length, path))
        for (axis, length), path in zip(_LENGTHS.items(), paths, strict=True)
    ]
    return Overlay(sizes=tuple((size(NAME, key), value) for key, value in sizes.items()), functions=tuple(moments))


TRIM_OFFSET = AircraftEffect(
    name=NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=PARAMETERS,
    source="rigging tolerances of maintenance manuals, 1 to 2° of tab or tail setting (estimate: 0.015 in pitch)",
    what="Rigging or trim differs: the surfaces have other positions in straight flight.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_build,
)
