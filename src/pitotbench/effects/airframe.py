"""Effects of the airframe: drag, loading, trim and controls."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

from pitotbench.effects.effect import (
    RANGE_OF_AIRSPEED,
    SIDESLIP,
    TURNING,
    AircraftEffect,
    Build,
    Parameter,
    Sizes,
    to_navajo,
)
from pitotbench.effects.overlay import (
    AxisFunction,
    Baseline,
    MassPoint,
    Overlay,
    PropertySetting,
    Term,
    difference,
    operation,
    product,
    size,
    total,
)
from pitotbench.records import BadInputError
from pitotbench.units import DEGREE, FOOT, POUND

WING = "metrics/Sw-sqft"


def _drag(factors: Callable[..., Iterable[Term]]) -> Build:
    """The build of a drag: dynamic pressure times `factors`, a function of the sizes' paths."""

    def build(effect: AircraftEffect, sizes: Sizes, _: Baseline) -> Overlay:
        drag = product("aero/qbar-psf", *factors(*effect.paths()))
        return Overlay(sizes=effect.properties(sizes), functions=(AxisFunction("DRAG", drag),))

    return build


BELLY_POD = AircraftEffect(
    name="belly_pod",
    left_open=("pitch_stiffness", "zero_lift"),
    part="drag",
    parameters=(
        Parameter(
            "drag_area_m2",
            0.1,
            -0.2,
            0.8,
            "drag area: drag over dynamic pressure",
            grows_with="wing area",
        ),
    ),
    source="Hoerner 1965, Fluid-Dynamic Drag, ch. 13: 0.1 on the frontal area of a fairing to 1 "
    "for blunt bodies; Martos, Kiszely and Foster 2011: the pod on the airplane, not in the model",
    what="A pod or antenna that the model lacks adds drag: less speed for the power.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_drag(lambda area: (area, 1.0 / FOOT**2)),
)


SURFACES = {"elevator_change": "elevator", "aileron_change": "aileron", "rudder_change": "rudder"}
AXES = ("LIFT", "DRAG", "SIDE", "ROLL", "PITCH", "YAW")
OWN_AXES = {"elevator": ("PITCH",), "aileron": ("ROLL",), "rudder": ("YAW",)}


def _controls(axes_of: Mapping[str, Sequence[str]]) -> Build:
    """The build of an effect that scales the functions of each surface in some axes."""

    def build(effect: AircraftEffect, sizes: Sizes, baseline: Baseline) -> Overlay:
        # A share of each function of the surface is added to its axis; the aircraft's functions
        # stay unchanged.
        added: list[AxisFunction] = []
        for key, surface in SURFACES.items():
            axes = axes_of[surface] if sizes[key] else ()
            moving = [function for axis in axes for function in baseline.terms(axis, surface)]
            if sizes[key] and not moving:
                raise BadInputError(
                    f"effect {effect.name!r}: no aerodynamic function of {baseline.aircraft!r} "
                    f"reads its {surface}; set {key} to 0"
                )
            added += [
                AxisFunction(each.axis, product(size(effect.name, key), each.name))
                for each in moving
            ]
        return Overlay(sizes=effect.properties(sizes), functions=tuple(added))

    return build


CONTROL_EFFECTIVENESS = AircraftEffect(
    name="control_effectiveness",
    part="controls and trim",
    by_size=True,
    parameters=(
        Parameter("elevator_change", -0.15, -0.6, 0.6, "elevator more effective by this share"),
        Parameter("aileron_change", -0.15, -0.6, 0.6, "ailerons more effective by this share"),
        Parameter("rudder_change", -0.15, -0.6, 0.6, "rudder more effective by this share"),
    ),
    source="DATCOM-class estimates of control derivatives err by 10 to 30 % (Hoak 1978, USAF "
    "DATCOM)",
    what="The surfaces must move more or less than in the model for the same motion.",
    shows_in=SIDESLIP,
    build=_controls(dict.fromkeys(SURFACES.values(), AXES)),
)

# A derivative of its own may be off: the moment of a surface about its own axis, and not its force.
CONTROL_MOMENTS = replace(
    CONTROL_EFFECTIVENESS,
    name="control_moments",
    variant_of="control_effectiveness",
    what="The surfaces give more or less moment about their own axes; their forces are those of "
    "the model.",
    build=_controls(OWN_AXES),
)


INCLINED_POD = AircraftEffect(
    name="inclined_pod",
    left_open=("pitch_stiffness", "zero_lift"),
    part="drag",
    parameters=(
        Parameter(
            "drag_area_m2",
            0.08,
            -0.2,
            0.8,
            "drag area with the pod along the flow",
            grows_with="wing area",
        ),
        Parameter(
            "growth_per_rad2",
            30.0,
            0.0,
            300.0,
            "relative growth of the drag, per square radian",
            shape=True,
        ),
    ),
    source="Hoerner 1965, Fluid-Dynamic Drag, ch. 13: bodies across the flow, cross-flow drag",
    what="A pod that the model lacks adds drag, and more at high angles of attack.",
    shows_in=RANGE_OF_AIRSPEED,  # the angle of attack is largest at the lowest airspeed
    variant_of="belly_pod",
    build=_drag(
        lambda area, growth: (
            area,
            1.0 / FOOT**2,
            total(1.0, product(growth, "aero/alpha-rad", "aero/alpha-rad")),
        )
    ),
)


INDUCED_DRAG = AircraftEffect(
    name="induced_drag",
    part="drag",
    parameters=(Parameter("factor", 0.010, -0.05, 0.08, "added k of C_D = C_D0 + k C_L²"),),
    source="lifting line, k = 1/(π A e): e 0.72 to 0.64 at an aspect ratio of 7.2 adds 0.008",
    what="The wing has more drag for its lift: slower at low speed and in turns.",
    shows_in=TURNING,
    build=_drag(lambda factor: (WING, factor, "aero/cl-squared")),
)


# in, over which ballast is moved, at the navajo's chord: any arm gives the same moment, and the
# ballast on one of 1.4 chords adds little to the moment of inertia
ARM = 100.0


def _center_of_gravity(effect: AircraftEffect, sizes: Sizes, baseline: Baseline) -> Overlay:
    x, y, z = baseline.center_of_gravity
    # Ballast is added aft and the same ballast is taken away at the center of gravity: the mass
    # stays, the moment changes. The file's inches are the unit of the arm.
    arm = ARM * to_navajo(baseline, "chord")
    moved = product(*effect.paths(), 12.0 / (FOOT * arm), "inertia/weight-lbs")
    return Overlay(
        sizes=effect.properties(sizes),
        masses=(MassPoint(moved, (x + arm, y, z)), MassPoint(product(-1.0, moved), (x, y, z))),
    )


MASS = AircraftEffect(
    name="mass",
    part="loading",
    like_without_vanes=True,
    parameters=(
        Parameter(
            "mass_kg",
            150.0,
            -600.0,
            600.0,
            "mass at the center of gravity beyond the loading",
            grows_with="empty mass",
        ),
    ),
    source="loading sheets: passengers, fuel and equipment to some 5 % of the weight",
    what="The airplane is heavier or lighter than the model.",
    shows_in=TURNING,
    build=lambda effect, sizes, baseline: Overlay(
        sizes=effect.properties(sizes),
        masses=(MassPoint(product(*effect.paths(), 1.0 / POUND), baseline.center_of_gravity),),
    ),
)

CENTER_OF_GRAVITY = AircraftEffect(
    name="center_of_gravity",
    part="loading",
    parameters=(
        Parameter(
            "aft_m",
            0.06,
            -0.25,
            0.25,
            "center of gravity behind that of the model",
            grows_with="chord",
        ),
    ),
    source="type certificate limits of the class: a range of some 0.3 m",
    what="The center of gravity is not where the model has it: elevator and pitch stability "
    "change.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_center_of_gravity,
)


def _lever(*levers: str) -> Build:
    """The build that holds the first of some levers that the aircraft has, else the last."""

    def build(effect: AircraftEffect, sizes: Sizes, baseline: Baseline) -> Overlay:
        lever = next((each for each in levers if each in baseline.declared), levers[-1])
        # Times one: an expression must be XML, and the bare path of a property is not.
        fixed = PropertySetting(lever, product(*effect.paths(), 1.0))
        return Overlay(sizes=effect.properties(sizes), settings=(fixed,))

    return build


FLAP_NOT_UP = AircraftEffect(
    name="flap_not_up",
    left_open=("pitch_stiffness", "zero_lift"),
    part="drag",
    parameters=(
        Parameter("extension", 0.15, 0.005, 1.0, "flaps down by this share of their travel"),
    ),
    source="a rigging error or a forgotten lever; lift and drag are those of the aircraft's flaps",
    what="The flaps are not fully up.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_lever("fcs/flap-cmd-norm"),
)

GEAR_NOT_UP = AircraftEffect(
    name="gear_not_up",
    left_open=("pitch_stiffness", "zero_lift"),
    part="drag",
    parameters=(
        Parameter(
            "extension", 0.3, 0.01, 1.0, "gear down by this share; a gear door is part of it"
        ),
    ),
    source="a door or a leg that does not close; the drag is that of the aircraft's gear",
    what="The gear is not fully up.",
    shows_in=RANGE_OF_AIRSPEED,
    one_model_with="belly_pod",
    build=_lever("fcs/gear-lever-norm", "gear/gear-cmd-norm"),  # the aircraft's own, else JSBSim's
)


def _bend(factor: str, onset: str) -> tuple[Term, ...]:
    beyond = operation("max", 0.0, difference(operation("sqrt", "aero/cl-squared"), onset))
    return WING, factor, beyond, beyond


POLAR_BEND = AircraftEffect(
    name="polar_bend",
    part="drag",
    parameters=(
        Parameter("factor", 0.05, -0.1, 0.4, "added drag coefficient over (C_L - onset)²"),
        Parameter("onset", 0.4, 0.0, 1.2, "lift coefficient at which it begins", shape=True),
    ),
    source="Hoerner 1965, Fluid-Dynamic Drag, ch. 7: viscous drag due to lift grows with (C_L - "
    "C_L0)²",
    what="The wing has more drag at high lift: slower at low speed and in turns.",
    shows_in=TURNING,  # high lift without slow flight
    variant_of="induced_drag",
    build=_drag(_bend),
)


LENGTHS = {"PITCH": "metrics/cbarw-ft", "ROLL": "metrics/bw-ft", "YAW": "metrics/bw-ft"}


def coefficient_function(axis: str, value: Term) -> AxisFunction:
    """The force or moment on an axis whose coefficient is `value`.

    The coefficient times dynamic pressure, wing area and, for a moment, reference length.
    """
    lengths = [LENGTHS[axis]] if axis in LENGTHS else []
    return AxisFunction(axis, product("aero/qbar-psf", WING, *lengths, value))


TRIM_OFFSET = AircraftEffect(
    name="trim_offset",
    part="controls and trim",
    parameters=(
        Parameter(
            "pitch_coefficient", 0.015, -0.1, 0.1, "added pitching-moment coefficient, nose up"
        ),
        Parameter(
            "roll_coefficient", 0.002, -0.02, 0.02, "added rolling-moment coefficient, right"
        ),
        Parameter(
            "yaw_coefficient", 0.002, -0.02, 0.02, "added yawing-moment coefficient, nose right"
        ),
    ),
    source="rigging tolerances of maintenance manuals, 1 to 2° of tab or tail setting (estimate: "
    "0.015 in pitch)",
    what="Rigging or trim differs: the surfaces have other positions in straight flight.",
    shows_in=RANGE_OF_AIRSPEED,
    build=lambda effect, sizes, baseline: Overlay(
        sizes=effect.properties(sizes),
        functions=tuple(map(coefficient_function, LENGTHS, effect.paths())),
    ),
)


SINE = operation("sin", "attitude/phi-rad")

TURN_DRAG = AircraftEffect(
    name="turn_drag",
    part="drag",
    parameters=(
        Parameter(
            "coefficient_at_30deg",
            0.005,
            -0.01,
            0.04,
            "added drag coefficient at 30° of bank, as sin²",
        ),
    ),
    source="Martos, Kiszely and Foster 2011: power had to be added in turns in flight, not in the "
    "simulator",
    what="The airplane loses more speed in turns than the model.",
    shows_in=TURNING,
    # sin² is the same for both sides and flat in level flight; over 0.25, its value at 30°, it
    # gives the size.
    build=_drag(lambda coefficient: (WING, coefficient, SINE, SINE, 1.0 / 0.25)),
)


STANDARD_RATE = 3.0 * DEGREE  # rad/s
TURN_RATE = operation("abs", product("velocities/psidot-rad_sec", 1.0 / STANDARD_RATE))

TURN_RATE_DRAG = AircraftEffect(
    name="turn_rate_drag",
    part="drag",
    parameters=(
        Parameter(
            "coefficient_at_3degps",
            0.004,
            -0.01,
            0.04,
            "added drag coefficient at 3°/s, linear in it",
        ),
    ),
    source="our form, an alternative to sin² of bank: rudder and aileron held against the turn "
    "grow with its rate",
    what="The airplane loses more speed in turns than the model.",
    shows_in=TURNING,
    variant_of="turn_drag",
    build=_drag(lambda coefficient: (WING, coefficient, TURN_RATE)),
)
