"""Effects of lift, stability and damping: a larger or smaller term of the aircraft's own file.

A term is every aerodynamic function of an axis in one variable of the motion: the lift in the angle
of attack, the rolling moment in the sideslip. Its change is a share of the aircraft's own function,
so that a table keeps its shape. What changes with the angle of attack has a zero near it: a slope
that was measured about the trim point says nothing about the value at zero.
"""

from collections.abc import Callable, Sequence

from pitotbench.effects.airframe import coefficient_function
from pitotbench.effects.effect import (
    RANGE_OF_AIRSPEED,
    SIDESLIP,
    TURNING,
    AircraftEffect,
    Build,
    Excitation,
    Parameter,
    Sizes,
)
from pitotbench.effects.overlay import (
    AeroFunction,
    AxisFunction,
    Baseline,
    Expression,
    FunctionScaling,
    Overlay,
    difference,
    product,
    size,
    total,
)
from pitotbench.records import BadInputError

CHANGE, ZERO = "change", "zero_coefficient"
SOURCE = (
    "Klein and Morelli 2006, Aircraft System Identification, ch. 5; estimates of derivatives "
    "err by 10 to 50 %"
)
NOTHING = difference(1.0, 1.0)


def _zero_lift(effect: AircraftEffect, sizes: Sizes, baseline: Baseline) -> Overlay:
    helpers = [term.name for term in baseline.terms("LIFT", "alpha") if not term.axis]
    added = product(*effect.paths(), 1.0)
    if helpers:
        return Overlay(
            sizes=effect.properties(sizes),
            scalings=(FunctionScaling(helpers[0], product(1.0, 1.0), added),),
        )
    return Overlay(sizes=effect.properties(sizes), functions=(coefficient_function("LIFT", added),))


def relative_change(
    terms_of: Callable[[Baseline], Sequence[AeroFunction]], named: str, axis: str = ""
) -> Build:
    """The build of a relative change of the functions that `terms_of` finds in an aircraft.

    The constant that an effect may have is added on `axis`. Raises BadInputError, with the words
    `named`, where there are no such functions.
    """

    def build(effect: AircraftEffect, sizes: Sizes, baseline: Baseline) -> Overlay:
        terms = terms_of(baseline)
        grown = size(effect.name, CHANGE)
        if not terms:
            raise BadInputError(
                f"effect {effect.name!r}: {baseline.aircraft!r} has no function {named}; "
                "leave it out"
            )
        helpers = [term.name for term in terms if not term.axis]
        added: Expression = product(size(effect.name, ZERO), 1.0) if sizes.get(ZERO) else ""
        functions = [
            AxisFunction(term.axis, product(grown, term.name)) for term in terms if term.axis
        ]
        if added and not helpers:
            functions.append(coefficient_function(axis, added))
        # A constant goes into the first function outside the axes: what reads this coefficient
        # reads it too.
        scalings = [
            FunctionScaling(
                helper, total(1.0, grown), added if added and helper == helpers[0] else NOTHING
            )
            for helper in helpers
        ]
        return Overlay(
            sizes=effect.properties(sizes), functions=tuple(functions), scalings=tuple(scalings)
        )

    return build


def _term(
    name: str,
    axis: str,
    variable: str,
    what: str,
    shows_in: Excitation,
    zero: Parameter | None = None,
    neighbor: str = "",
    left_open: tuple[str, ...] = (),
) -> AircraftEffect:
    what_changes = "relative change of the term of the aircraft's file"
    change = Parameter(CHANGE, 0.2, -0.8, 1.5, what_changes, defining=bool(neighbor))
    return AircraftEffect(
        name=name,
        part="lift, stability and damping",
        neighbor=neighbor,
        left_open=left_open,
        parameters=(change, zero) if zero else (change,),
        source=SOURCE,
        what=what,
        shows_in=shows_in,
        for_whole_flight=True,
        like_without_vanes=axis == "LIFT",
        build=relative_change(
            lambda baseline: baseline.terms(axis, variable),
            f"of {axis.lower()} in {variable}",
            axis,
        ),
    )


LIFT_SLOPE = _term(
    "lift_slope",
    "LIFT",
    "alpha",
    "The lift grows more or less with the angle of attack.",
    RANGE_OF_AIRSPEED,
    Parameter(
        ZERO, 0.05, -0.6, 0.6, "added lift coefficient at zero angle of attack", may_be_missing=True
    ),
    neighbor="zero_lift",
    left_open=("induced_drag",),
)

ZERO_LIFT = AircraftEffect(
    name="zero_lift",
    part="lift, stability and damping",
    like_without_vanes=True,
    parameters=(
        Parameter(
            "lift_coefficient", 0.05, -0.4, 0.4, "added lift coefficient at any angle of attack"
        ),
    ),
    source="wing incidence and body attitude are set to some 0.5°, which is 0.04 of lift "
    "coefficient (estimate)",
    what="The wing has more or less lift at the same angle of attack.",
    shows_in=RANGE_OF_AIRSPEED,
    for_whole_flight=True,
    build=_zero_lift,
)

PITCH_STIFFNESS = _term(
    "pitch_stiffness",
    "PITCH",
    "alpha",
    "The pitching moment falls more or less with the angle of attack.",
    RANGE_OF_AIRSPEED,
    Parameter(
        ZERO,
        0.015,
        -0.15,
        0.15,
        "added pitching-moment coefficient at zero angle",
        may_be_missing=True,
    ),
)
PITCH_DAMPING = _term(
    "pitch_damping", "PITCH", "q", "The pitch rate is damped more or less.", TURNING
)
SIDE_FORCE = _term(
    "side_force", "SIDE", "sideslip", "A sideslip gives more or less side force.", SIDESLIP
)
DIHEDRAL_EFFECT = _term(
    "dihedral_effect", "ROLL", "sideslip", "A sideslip rolls the airplane more or less.", SIDESLIP
)
WEATHERCOCK_STABILITY = _term(
    "weathercock_stability",
    "YAW",
    "sideslip",
    "A sideslip yaws the airplane more or less.",
    SIDESLIP,
)
ROLL_DAMPING = _term("roll_damping", "ROLL", "p", "The roll rate is damped more or less.", TURNING)
YAW_DAMPING = _term("yaw_damping", "YAW", "r", "The yaw rate is damped more or less.", TURNING)
ROLL_BY_YAW_RATE = _term(
    "roll_by_yaw_rate", "ROLL", "r", "A yaw rate rolls the airplane more or less.", TURNING
)
