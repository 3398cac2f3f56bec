"""Effects of the airframe: drag, loading, trim and controls."""

from collections.abc import Mapping

from pitotbench.effects.effect import RANGE_OF_AIRSPEED, SIDESLIP, TURNING, AircraftEffect, Parameter
from pitotbench.effects.overlay import (
    AxisFunction,
    Baseline,
    MassPoint,
    Overlay,
    PropertySetting,
    difference,
    operation,
    product,
    size,
    total,
)
from pitotbench.records import BadInputError
from pitotbench.units import DEGREE, FOOT, POUND

# A pod or antenna that the model lacks: drag in proportion to dynamic pressure.

BELLY_POD_NAME = "belly_pod"

_AREA = size(BELLY_POD_NAME, "drag_area_m2")


def _build_belly_pod(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    drag = product("aero/qbar-psf", _AREA, 1.0 / FOOT**2)
    return Overlay(sizes=((_AREA, sizes["drag_area_m2"]),), functions=(AxisFunction("DRAG", drag),))


BELLY_POD = AircraftEffect(
    name=BELLY_POD_NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=(Parameter("drag_area_m2", 0.1, -0.2, 0.8, "drag area: drag over dynamic pressure"),),
    source="Hoerner 1965, Fluid-Dynamic Drag, ch. 13: 0.1 on the frontal area of a fairing to 1 for blunt bodies; "
    "Martos, Kiszely and Foster 2011: the pod on the airplane, not in the model",
    what="A pod or antenna that the model lacks adds drag: less speed for the power.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_build_belly_pod,
)


# Controls that are more or less effective than in the model: every force and moment of a surface is scaled.

EFFECTIVENESS = "control_effectiveness"

SURFACES = {
    "elevator_change": "fcs/elevator-pos-rad",
    "aileron_change": "fcs/left-aileron-pos-rad",
    "rudder_change": "fcs/rudder-pos-rad",
}

AXES = ("LIFT", "DRAG", "SIDE", "ROLL", "PITCH", "YAW")


def _build_control_effectiveness(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    # A share of each function that reads the surface is added to its axis; the aircraft's functions stay unchanged.
    added = [
        AxisFunction(axis, product(size(EFFECTIVENESS, key), function))
        for key in SURFACES
        if sizes[key] != 0.0
        for axis in AXES
        for function in _moving(baseline, axis, key)
    ]
    return Overlay(
        sizes=tuple((size(EFFECTIVENESS, key), value) for key, value in sizes.items()), functions=tuple(added)
    )


def _moving(baseline: Baseline, axis: str, key: str) -> tuple[str, ...]:
    control = SURFACES[key]
    if not any(baseline.moving(a, control) for a in AXES):
        raise BadInputError(
            f"effect {EFFECTIVENESS!r}: no aerodynamic function of {baseline.aircraft!r} reads {control}; "
            f"set {key} to 0"
        )
    return baseline.moving(axis, control)


CONTROL_EFFECTIVENESS = AircraftEffect(
    name=EFFECTIVENESS,
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
    build=_build_control_effectiveness,
)


# A pod whose drag grows with the angle of attack.

INCLINED_POD_NAME = "inclined_pod"

INCLINED_POD_PARAMETERS = (
    Parameter("drag_area_m2", 0.08, -0.2, 0.8, "drag area with the pod along the flow"),
    Parameter("growth_per_rad2", 30.0, 0.0, 300.0, "relative growth of the drag, per square radian", shape=True),
)


def _build_inclined_pod(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    area, growth = (size(INCLINED_POD_NAME, p.name) for p in INCLINED_POD_PARAMETERS)
    grown = total(1.0, product(growth, "aero/alpha-rad", "aero/alpha-rad"))
    drag = product("aero/qbar-psf", area, 1.0 / FOOT**2, grown)
    return Overlay(
        sizes=tuple((size(INCLINED_POD_NAME, key), value) for key, value in sizes.items()),
        functions=(AxisFunction("DRAG", drag),),
    )


INCLINED_POD = AircraftEffect(
    name=INCLINED_POD_NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=INCLINED_POD_PARAMETERS,
    source="Hoerner 1965, Fluid-Dynamic Drag, ch. 13: bodies across the flow, cross-flow drag",
    what="A pod that the model lacks adds drag, and more at high angles of attack.",
    shows_in=RANGE_OF_AIRSPEED,  # the angle of attack is largest at the lowest airspeed
    variant_of="belly_pod",
    build=_build_inclined_pod,
)


# More drag for the same lift: a wing that is less efficient than in the model.

INDUCED_DRAG_NAME = "induced_drag"

_FACTOR = size(INDUCED_DRAG_NAME, "factor")


def _build_induced_drag(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    drag = product("aero/qbar-psf", "metrics/Sw-sqft", _FACTOR, "aero/cl-squared")
    return Overlay(sizes=((_FACTOR, sizes["factor"]),), functions=(AxisFunction("DRAG", drag),))


INDUCED_DRAG = AircraftEffect(
    name=INDUCED_DRAG_NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=(Parameter("factor", 0.010, -0.05, 0.08, "added k of C_D = C_D0 + k C_L²"),),
    source="lifting line, k = 1/(π A e): e 0.72 to 0.64 at an aspect ratio of 7.2 adds 0.008",
    what="The wing has more drag for its lift: slower at low speed and in turns.",
    shows_in=TURNING,
    build=_build_induced_drag,
)


# Loading: more or less mass at the center of gravity, or a center of gravity farther aft or forward.

ARM = 100.0  # in, over which ballast is moved; any arm gives the same moment

_MASS, _AFT = size("mass", "mass_kg"), size("center_of_gravity", "aft_m")


def _mass(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    added = MassPoint(product(_MASS, 1.0 / POUND), baseline.center_of_gravity)
    return Overlay(sizes=((_MASS, sizes["mass_kg"]),), masses=(added,))


def _center_of_gravity(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    x, y, z = baseline.center_of_gravity
    # Ballast is added aft and the same ballast is taken away at the center of gravity: the mass stays, the moment
    # changes. The file's inches are the unit of the arm.
    moved = product(_AFT, 12.0 / (FOOT * ARM), "inertia/weight-lbs")
    masses = (MassPoint(moved, (x + ARM, y, z)), MassPoint(product(-1.0, moved), (x, y, z)))
    return Overlay(sizes=((_AFT, sizes["aft_m"]),), masses=masses)


MASS = AircraftEffect(
    name="mass",
    family="airframe",
    acts_on="aircraft",
    parameters=(Parameter("mass_kg", 150.0, -600.0, 600.0, "mass at the center of gravity beyond the loading"),),
    source="loading sheets: passengers, fuel and equipment to some 5 % of the weight",
    what="The airplane is heavier or lighter than the model.",
    shows_in=TURNING,
    build=_mass,
)

CENTER_OF_GRAVITY = AircraftEffect(
    name="center_of_gravity",
    family="airframe",
    acts_on="aircraft",
    parameters=(Parameter("aft_m", 0.06, -0.25, 0.25, "center of gravity behind that of the model"),),
    source="type certificate limits of the class: a range of some 0.3 m",
    what="The center of gravity is not where the model has it: elevator and pitch stability change.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_center_of_gravity,
)


# Flaps or gear that are not fully up. Lift and drag follow from the flap and gear terms of the aircraft.

_FLAP, _GEAR = size("flap_not_up", "extension"), size("gear_not_up", "extension")

LEVERS = ("fcs/gear-lever-norm", "gear/gear-cmd-norm")  # the aircraft's lever where it has one, else JSBSim's


def _flap(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    # Times one: an expression must be XML, and the bare path of a property is not.
    held = PropertySetting("fcs/flap-cmd-norm", product(_FLAP, 1.0))
    return Overlay(sizes=((_FLAP, sizes["extension"]),), settings=(held,))


def _gear(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    lever = LEVERS[0] if LEVERS[0] in baseline.declared else LEVERS[1]
    return Overlay(sizes=((_GEAR, sizes["extension"]),), settings=(PropertySetting(lever, product(_GEAR, 1.0)),))


FLAP_NOT_UP = AircraftEffect(
    name="flap_not_up",
    family="airframe",
    acts_on="aircraft",
    parameters=(Parameter("extension", 0.15, 0.005, 1.0, "flaps down by this share of their travel"),),
    source="a rigging error or a forgotten lever; lift and drag are those of the aircraft's flaps",
    what="The flaps are not fully up.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_flap,
)

GEAR_NOT_UP = AircraftEffect(
    name="gear_not_up",
    family="airframe",
    acts_on="aircraft",
    parameters=(Parameter("extension", 0.3, 0.01, 1.0, "gear down by this share; a gear door is part of it"),),
    source="a door or a leg that does not close; the drag is that of the aircraft's gear",
    what="The gear is not fully up.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_gear,
)


# A drag polar that bends up at high lift, where the flow begins to separate from the wing.

POLAR_BEND_NAME = "polar_bend"

POLAR_BEND_PARAMETERS = (
    Parameter("factor", 0.05, -0.1, 0.4, "added drag coefficient over (C_L - onset)²"),
    Parameter("onset", 0.4, 0.0, 1.2, "lift coefficient at which it begins", shape=True),
)


def _build_polar_bend(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    factor, onset = (size(POLAR_BEND_NAME, p.name) for p in POLAR_BEND_PARAMETERS)
    beyond = operation("max", 0.0, difference(operation("sqrt", "aero/cl-squared"), onset))
    drag = product("aero/qbar-psf", "metrics/Sw-sqft", factor, beyond, beyond)
    return Overlay(
        sizes=tuple((size(POLAR_BEND_NAME, key), value) for key, value in sizes.items()),
        functions=(AxisFunction("DRAG", drag),),
    )


POLAR_BEND = AircraftEffect(
    name=POLAR_BEND_NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=POLAR_BEND_PARAMETERS,
    source="Hoerner 1965, Fluid-Dynamic Drag, ch. 7: viscous drag due to lift grows with (C_L - C_L0)²",
    what="The wing has more drag at high lift: slower at low speed and in turns.",
    shows_in=TURNING,  # high lift without slow flight
    variant_of="induced_drag",
    build=_build_polar_bend,
)


# Trim or rigging: a constant moment about each axis that the surfaces must hold.

TRIM_OFFSET_NAME = "trim_offset"

TRIM_OFFSET_PARAMETERS = (
    Parameter("pitch_coefficient", 0.015, -0.1, 0.1, "added pitching-moment coefficient, nose up"),
    Parameter("roll_coefficient", 0.002, -0.02, 0.02, "added rolling-moment coefficient, right"),
    Parameter("yaw_coefficient", 0.002, -0.02, 0.02, "added yawing-moment coefficient, nose right"),
)

_LENGTHS = {"PITCH": "metrics/cbarw-ft", "ROLL": "metrics/bw-ft", "YAW": "metrics/bw-ft"}


def _build_trim_offset(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    # Moment = dynamic pressure × wing area × reference length × coefficient, as in the aircraft's file.
    paths = [size(TRIM_OFFSET_NAME, p.name) for p in TRIM_OFFSET_PARAMETERS]
    moments = [
        AxisFunction(axis, product("aero/qbar-psf", "metrics/Sw-sqft", length, path))
        for (axis, length), path in zip(_LENGTHS.items(), paths, strict=True)
    ]
    return Overlay(
        sizes=tuple((size(TRIM_OFFSET_NAME, key), value) for key, value in sizes.items()), functions=tuple(moments)
    )


TRIM_OFFSET = AircraftEffect(
    name=TRIM_OFFSET_NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=TRIM_OFFSET_PARAMETERS,
    source="rigging tolerances of maintenance manuals, 1 to 2° of tab or tail setting (estimate: 0.015 in pitch)",
    what="Rigging or trim differs: the surfaces have other positions in straight flight.",
    shows_in=RANGE_OF_AIRSPEED,
    build=_build_trim_offset,
)


# Drag that appears only in a bank: deflected surfaces, a skid, the pilot's control movements in the turn.

TURN_DRAG_NAME = "turn_drag"

SIN_SQUARED_30 = 0.25

_TURN_DRAG_COEFFICIENT = size(TURN_DRAG_NAME, "coefficient_at_30deg")


def _build_turn_drag(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    # sin² is the same for both sides and flat in level flight; over that of 30° it gives the coefficient there.
    sine = operation("sin", "attitude/phi-rad")
    drag = product("aero/qbar-psf", "metrics/Sw-sqft", _TURN_DRAG_COEFFICIENT, sine, sine, 1.0 / SIN_SQUARED_30)
    return Overlay(
        sizes=((_TURN_DRAG_COEFFICIENT, sizes["coefficient_at_30deg"]),), functions=(AxisFunction("DRAG", drag),)
    )


TURN_DRAG = AircraftEffect(
    name=TURN_DRAG_NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=(
        Parameter("coefficient_at_30deg", 0.005, -0.01, 0.04, "added drag coefficient at 30° of bank, as sin²"),
    ),
    source="Martos, Kiszely and Foster 2011: power had to be added in turns in flight, not in the simulator",
    what="The airplane loses more speed in turns than the model.",
    shows_in=TURNING,
    build=_build_turn_drag,
)


# Drag in proportion to the rate of turn instead of the bank.

TURN_RATE_DRAG_NAME = "turn_rate_drag"

STANDARD_RATE = 3.0 * DEGREE  # rad/s

_TURN_RATE_DRAG_COEFFICIENT = size(TURN_RATE_DRAG_NAME, "coefficient_at_3degps")


def _build_turn_rate_drag(sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    rate = operation("abs", product("velocities/psidot-rad_sec", 1.0 / STANDARD_RATE))
    drag = product("aero/qbar-psf", "metrics/Sw-sqft", _TURN_RATE_DRAG_COEFFICIENT, rate)
    return Overlay(
        sizes=((_TURN_RATE_DRAG_COEFFICIENT, sizes["coefficient_at_3degps"]),),
        functions=(AxisFunction("DRAG", drag),),
    )


TURN_RATE_DRAG = AircraftEffect(
    name=TURN_RATE_DRAG_NAME,
    family="airframe",
    acts_on="aircraft",
    parameters=(
        Parameter("coefficient_at_3degps", 0.004, -0.01, 0.04, "added drag coefficient at 3°/s, linear in it"),
    ),
    source="our form, an alternative to sin² of bank: rudder and aileron held against the turn grow with its rate",
    what="The airplane loses more speed in turns than the model.",
    shows_in=TURNING,
    variant_of="turn_drag",
    build=_build_turn_rate_drag,
)
