"""Terms of an aircraft's own file as effects: any aerodynamic function may be larger or smaller.

The table has the terms that every airplane has. A file may have others: side force by the roll
rate, yaw moment by the ailerons. Each is an effect that goes by its name in the field and by its
function, `yaw_moment_by_roll_rate/aero/coefficient/Cnp`: the name alone says all that the effect
is, so that a case, a patch and a report may hold it as they hold any other.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache

from pitotbench.effects.effect import RANGE_OF_AIRSPEED, AircraftEffect, Parameter, Part
from pitotbench.effects.overlay import (
    AeroFunction,
    Baseline,
)
from pitotbench.effects.stability import CHANGE, SOURCE, relative_change

AXIS_CHANNEL = {
    "DRAG": "drag",
    "SIDE": "side force",
    "LIFT": "lift",
    "ROLL": "roll moment",
    "PITCH": "pitch moment",
    "YAW": "yaw moment",
}
NAMES = {
    ("LIFT", "alpha"): "lift slope",
    ("LIFT", ""): "zero lift",
    ("DRAG", ""): "parasite drag",
    ("DRAG", "lift"): "induced drag",
    ("SIDE", "sideslip"): "side force",
    ("ROLL", "sideslip"): "dihedral effect",
    ("ROLL", "p"): "roll damping",
    ("PITCH", "alpha"): "pitch stiffness",
    ("PITCH", "q"): "pitch damping",
    ("PITCH", ""): "zero pitch moment",
    ("YAW", "sideslip"): "weathercock stability",
    ("YAW", "r"): "yaw damping",
    ("PITCH", "elevator"): "elevator effectiveness",
    ("ROLL", "aileron"): "aileron effectiveness",
    ("YAW", "rudder"): "rudder effectiveness",
}
VARIABLES = {
    "p": "roll rate",
    "q": "pitch rate",
    "r": "yaw rate",
    "alpha": "angle of attack",
    "alpha_rate": "rate of the angle of attack",
    "setting": "flaps, gear or power",
    "lift": "lift",
}
# Terms that are forms of a cause of the table: the same derivative, one function of it alone.
FORM_OF = {
    "induced_drag": "induced_drag",
    "lift_slope": "lift_slope",
    "side_force": "side_force",
    "dihedral_effect": "dihedral_effect",
    "roll_damping": "roll_damping",
    "roll_moment_by_yaw_rate": "roll_by_yaw_rate",
    "pitch_stiffness": "pitch_stiffness",
    "pitch_damping": "pitch_damping",
    "weathercock_stability": "weathercock_stability",
    "yaw_damping": "yaw_damping",
    "elevator_effectiveness": "control_effectiveness",
    "aileron_effectiveness": "control_effectiveness",
    "rudder_effectiveness": "control_effectiveness",
}
DRAGS = ("drag", "parasite_drag", "induced_drag")  # beginnings of names
SURFACES = ("elevator", "aileron", "rudder")


@dataclass(frozen=True, slots=True)
class Term:
    """A term that may change: its function, the axis of its report, and its name in the field."""

    function: AeroFunction
    axis: str
    name: str


def terms_of(baseline: Baseline) -> tuple[Term, ...]:
    """Return the terms of an aircraft's file: functions with numbers, on an axis or read by one.

    The numbers are a table or a constant. Terms of one name are told apart by the names of their
    functions.
    """
    found: dict[AeroFunction, str] = {}
    for axis in AXIS_CHANNEL:
        for function in baseline.functions:
            if function.axis == axis:
                if function.numbers:
                    found.setdefault(_in_lift(baseline, function), axis)
                for helper in baseline.behind(function):
                    if helper.numbers and helper.variable:
                        found.setdefault(helper, "LIFT" if axis in ("LIFT", "DRAG") else axis)
    named = [(function, axis, _name(axis, function)) for function, axis in found.items()]
    count = {name: sum(n == name for *_, n in named) for *_, name in named}
    return tuple(
        Term(f, axis, name if count[name] == 1 else f"{name} ({f.name.rsplit('/', 1)[-1]})")
        for f, axis, name in named
    )


def _in_lift(baseline: Baseline, function: AeroFunction) -> AeroFunction:
    """A function of drag that reads a lift coefficient is one of the lift."""
    lifts = any(helper.variable == "alpha" for helper in baseline.behind(function))
    if function.axis == "DRAG" and not function.variable and lifts:
        return replace(function, reads=function.reads | {"aero/cl-squared"})
    return function


def _name(axis: str, function: AeroFunction) -> str:
    variable = function.variable
    label = AXIS_CHANNEL[axis]
    return NAMES.get((axis, variable)) or (
        f"{label} by {VARIABLES.get(variable, variable)}" if variable else label
    )


@cache
def term_named(name: str) -> AircraftEffect | None:
    """Return the effect of a term by its name; None for a name that is none of a term."""
    label, separator, function = name.partition("/")
    if not separator:
        return None
    part: Part = "lift, stability and damping"
    if label.startswith(DRAGS):
        part = "drag"
    elif any(surface in label for surface in SURFACES):
        part = "controls and trim"
    return AircraftEffect(
        name=name,
        part=part,
        parameters=(Parameter(CHANGE, 0.2, -1.0, 3.0, f"relative change of {function}"),),
        source=SOURCE,
        what=f"The function {function} of the aircraft's file is larger or smaller.",
        shows_in=RANGE_OF_AIRSPEED,
        variant_of=FORM_OF.get(label, ""),
        for_whole_flight=True,
        build=relative_change(
            lambda baseline: [f for f in baseline.functions if f.name == function][:1], function
        ),
    )


def own_terms(baseline: Baseline, table: Iterable[AircraftEffect]) -> Iterator[AircraftEffect]:
    """Yield the terms of an aircraft's file that no effect of a `table` changes alone.

    The constant of an axis is among them: the drag of a pod, zero lift or trim.
    """
    terms = terms_of(baseline)
    own = {term.function.name for term in terms}
    changed = (o.functions_changed() & own for effect in table for o in effect.fitting(baseline))
    known = {name for names in changed if len(names) == 1 for name in names}
    for term in terms:
        if term.function.variable and term.function.name not in known:
            name = _name(term.axis, term.function).replace(" ", "_").replace(",", "")
            if effect := term_named(f"{name}/{term.function.name}"):
                yield effect
