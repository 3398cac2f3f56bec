"""Controls that are more or less effective than in the model: every force and moment of a surface is scaled."""

from collections.abc import Mapping

from pitotbench.effects.effect import AircraftEffect, Parameter
from pitotbench.effects.excitation import SIDESLIP
from pitotbench.effects.expression import product, size
from pitotbench.effects.overlay import AxisFunction, Baseline, Overlay
from pitotbench.records.errors import BadInputError

NAME = "control_effectiveness"
SURFACES = {
    "elevator_change": "fcs/elevator-pos-rad",
    "aileron_change": "fcs/left-aileron-pos-rad",
    "rudder_change": "fcs/rudder-pos-rad",
}
AXES = ("LIFT", "DRAG", "SIDE", "ROLL", "PITCH", "YAW")


def _build(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    # A share of each function that reads the surface is added to its axis; the aircraft's functions stay unchanged.
    added = [
        AxisFunction(axis, product(size(NAME, key), function))
        for key in SURFACES
        if sizes[key] != 0.0
        for axis in AXES
        for function in _moving(baseline, axis, key)
    ]
    return Overlay(sizes=tuple((size(NAME, key), value) for key, value in sizes.items()), functions=tuple(added))


def _moving(baseline: Baseline, axis: str, key: str) -> tuple[str, ...]:
    control = SURFACES[key]
    if not any(baseline.moving(a, control) for a in AXES):
        raise BadInputError(
            f"effect {NAME!r}: no aerodynamic function of {baseline.aircraft!r} reads {control}; set {key} to 0"
        )
    return baseline.moving(axis, control)


CONTROL_EFFECTIVENESS = AircraftEffect(
    name=NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=(
        Parameter("elevator_change", -0.15, -0.6, 0.6, "elevator more effective by this share"),
        Parameter("aileron_change", -0.15, -0.6, 0.6, "ailerons more effective by this share"),
        Parameter("rudder_change", -0.15, -0.6, 0.6, "rudder more effective by this share"),
    ),
    source="DATCOM-class estimates of control derivatives err by 10 to 30 % (Hoak 1978, USAF DATCOM)",
    what="The surfaces must move more or less than in the model for the same motion.",
    shows_in=SIDESLIP,
    build=_build,
)
