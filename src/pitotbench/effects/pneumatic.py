"""Effects of the pitot-static system: lines, transducers and the error of the static source."""

from collections.abc import Callable

import numpy as np

from pitotbench import air
from pitotbench.effects.effect import (
    CHANGING_AIRSPEED,
    CHANGING_HEIGHT,
    EARLY_AND_LATE,
    POWER,
    RANGE_OF_AIRSPEED,
    SIDESLIP,
    STEPS_OF_AIRSPEED,
    Excitation,
    Parameter,
    SensorEffect,
    SensorFunction,
    Sizes,
    elapsed,
    reads,
)
from pitotbench.effects.response import (
    Signals,
    displaced,
    first_order,
    first_order_varying,
    play,
    second_order,
)
from pitotbench.units import INCH_OF_MERCURY, KNOT, MINUTE, SUFFIXES, Array

Response = Callable[[Signals, Array, Sizes], Array]


def _in_pitot_line(respond: Response) -> SensorFunction:
    """The function of a line that changes the total pressure, but not the static one.

    The transducer subtracts the static pressure at once.
    """

    def function(signals: Signals, sizes: Sizes) -> Signals:
        static = signals["static_pressure"]
        total = respond(signals, signals["impact_pressure"] + static, sizes)
        return signals.with_channels(impact_pressure=total - static)

    return function


FLOW_ANGLE_SOURCE = "Gracey 1980, NASA RP-1046: static-pressure error with angle of attack and yaw"


def _sideslip(signals: Signals, sizes: Sizes) -> Signals:
    beta = signals["sideslip"]
    coefficient = sizes["slope_per_rad"] * beta + sizes["curvature_per_rad2"] * beta**2
    return displaced(signals, coefficient * signals["impact_pressure"])


ALPHA_STATIC_ERROR = SensorEffect(
    name="alpha_static_error",
    part="static ports and line",
    parameters=(
        Parameter("slope_per_rad", 0.15, -1.0, 1.0, "static error over impact pressure per radian"),
    ),
    source=FLOW_ANGLE_SOURCE,
    what="The static-pressure error depends on angle of attack, so it changes in turns and with "
    "weight.",
    shows_in=RANGE_OF_AIRSPEED,
    changes=("impact_pressure", "static_pressure"),
    needs=("angle_of_attack",),
    function=lambda signals, sizes: displaced(
        signals, sizes["slope_per_rad"] * signals["angle_of_attack"] * signals["impact_pressure"]
    ),
)

SIDESLIP_STATIC_ERROR = SensorEffect(
    name="sideslip_static_error",
    part="static ports and line",
    parameters=(
        Parameter(
            "slope_per_rad",
            0.10,
            -2.0,
            2.0,
            "static error over impact pressure per radian: one port only",
        ),
        Parameter(
            "curvature_per_rad2",
            -1.5,
            -200.0,  # one port alone reads over one side: a slope of 2 within 0.01 rad
            200.0,
            "the same per square radian: two joined ports keep it",
        ),
    ),
    source=FLOW_ANGLE_SOURCE,
    what="The static pressure has an error in sideslip.",
    shows_in=SIDESLIP,
    changes=("impact_pressure", "static_pressure"),
    needs=("sideslip",),
    function=_sideslip,
)


def _apply_creep(signals: Signals, sizes: Sizes) -> Signals:
    impact = signals["impact_pressure"]
    behind = impact - first_order(signals, impact, sizes["creep_s"])
    return signals.with_channels(impact_pressure=impact - sizes["fraction"] * behind)


CREEP = SensorEffect(
    name="creep",
    part="impact transducer",
    parameters=(
        Parameter("fraction", 0.02, -0.2, 0.3, "part of a change that appears slowly"),
        Parameter("creep_s", 40.0, 1.0, 1000.0, "time constant of that part", shape=True),
    ),
    source="Gracey 1980, NASA RP-1046: drift and after-effect of elastic capsules; one relaxation "
    "time",
    what="Readings differ between rising and falling pressure, and the difference depends on the "
    "rate.",
    shows_in=CHANGING_AIRSPEED,  # the slow part appears in the legs between the changes
    variant_of="hysteresis",
    changes=("impact_pressure",),
    function=_apply_creep,
)


def _height_dependent_lag(signals: Signals, total: Array, sizes: Sizes) -> Array:
    static = signals["static_pressure"]
    temperature = air.standard_temperature(air.pressure_altitude(static))
    # Relative to sea level; the viscosity of air rises nearly as temperature to the power of 0.75.
    viscosity = (temperature / air.SEA_LEVEL_TEMPERATURE) ** 0.75
    lag = np.asarray(sizes["sea_level_lag_s"] * viscosity * air.SEA_LEVEL_PRESSURE / static)
    return first_order_varying(signals, total, lag)


HEIGHT_DEPENDENT_LAG = SensorEffect(
    name="height_dependent_lag",
    part="pitot line",
    parameters=(
        Parameter("sea_level_lag_s", 0.35, 0.01, 3.0, "time constant of the line at sea level"),
    ),
    source="Gracey 1980, NASA RP-1046, pressure-system lag: time constant as viscosity over "
    "pressure",
    what="The total-pressure line is late, and later the higher the airplane flies.",
    shows_in=Excitation(
        ("rapid_decel",), "the same decelerations at two heights some 3,000 m apart"
    ),
    variant_of="pitot_lag",
    changes=("impact_pressure",),
    needs=("static_pressure",),
    function=_in_pitot_line(_height_dependent_lag),
)


HYSTERESIS_SOURCE = (
    "Krasnosel'skii and Pokrovskii 1989, Systems with Hysteresis; data sheets: 0.1 % of full scale"
)


HYSTERESIS = SensorEffect(
    name="hysteresis",
    part="impact transducer",
    parameters=(
        Parameter(
            "width_pa", 25.0, 1.0, 300.0, "reading at falling minus reading at rising pressure"
        ),
    ),
    source=HYSTERESIS_SOURCE,
    what="Decelerations read higher than accelerations at the same speed.",
    shows_in=CHANGING_AIRSPEED,
    changes=("impact_pressure",),
    function=reads("impact_pressure", lambda pressure, sizes: play(pressure, sizes["width_pa"])),
)

STATIC_HYSTERESIS = SensorEffect(
    name="static_hysteresis",
    part="static transducer",
    parameters=(
        Parameter(
            "width_pa", 100.0, 5.0, 1500.0, "reading at falling minus reading at rising pressure"
        ),
    ),
    source=HYSTERESIS_SOURCE,
    what="The static pressure reads higher in a climb than in a descent at the same height.",
    shows_in=CHANGING_HEIGHT,
    changes=("static_pressure",),
    function=reads("static_pressure", lambda pressure, sizes: play(pressure, sizes["width_pa"])),
)


LAG_SOURCE = "Gracey 1980, NASA RP-1046, ch. on pressure-system lag: first-order line"


def _static_line_lag(signals: Signals, sizes: Sizes) -> Signals:
    # Both transducers are connected to this line, so its delay appears in both, with opposite
    # signs.
    static = signals["static_pressure"]
    late = first_order(signals, static, sizes["lag_s"])
    return signals.with_channels(
        static_pressure=late, impact_pressure=signals["impact_pressure"] + static - late
    )


PITOT_LAG = SensorEffect(
    name="pitot_lag",
    part="pitot line",
    parameters=(Parameter("lag_s", 0.4, 0.01, 3.0, "time constant of the total-pressure line"),),
    source=LAG_SOURCE,
    what="The total-pressure line is long or thin: indicated airspeed follows late.",
    shows_in=CHANGING_AIRSPEED,
    changes=("impact_pressure",),
    needs=("static_pressure",),
    function=_in_pitot_line(
        lambda signals, total, sizes: first_order(signals, total, sizes["lag_s"])
    ),
)

STATIC_LAG = SensorEffect(
    name="static_lag",
    part="static ports and line",
    parameters=(Parameter("lag_s", 0.6, 0.01, 5.0, "time constant of the static-pressure line"),),
    source=LAG_SOURCE,
    what="The static-pressure line is long or thin: altitude follows late, and airspeed errs in "
    "climbs.",
    shows_in=CHANGING_HEIGHT,
    changes=("impact_pressure", "static_pressure"),
    function=_static_line_lag,
)


def _apply_line_leak(signals: Signals, sizes: Sizes) -> Signals:
    impact, lost = signals["impact_pressure"], sizes["fraction"] * signals["impact_pressure"]
    static = signals["static_pressure"] + sizes["static_share"] * lost
    return signals.with_channels(impact_pressure=impact - lost, static_pressure=static)


LINE_LEAK = SensorEffect(
    name="line_leak",
    part="static ports and line",
    parameters=(
        Parameter("fraction", 0.02, 0.001, 0.3, "share of the impact pressure that leaks away"),
        Parameter(
            "static_share",
            0.5,
            0.0,
            1.0,
            "part of the loss that appears in the static line",
            shape=True,
        ),
    ),
    source="laminar flow through three resistances in series, pitot line, leak, static line "
    "(Hagen-Poiseuille); leak tests of FAA AC 43.13-1B, 12-58 and 12-59",
    what="The pitot line leaks into the static line: airspeed low, static pressure high.",
    shows_in=CHANGING_HEIGHT,
    changes=("impact_pressure", "static_pressure"),
    function=_apply_line_leak,
)


def _apply_local_static_bump(signals: Signals, sizes: Sizes) -> Signals:
    impact = signals["impact_pressure"]
    away = (air.calibrated_airspeed(impact.clip(min=0.0)) - sizes["center_mps"]) / sizes[
        "width_mps"
    ]
    return displaced(signals, sizes["coefficient"] * np.exp(-0.5 * away**2) * impact)


LOCAL_STATIC_BUMP = SensorEffect(
    name="local_static_bump",
    part="static ports and line",
    parameters=(
        Parameter(
            "coefficient",
            0.010,
            -0.1,
            0.1,
            "static error over impact pressure at the band's center",
        ),
        Parameter("center_mps", 65.0, 40.0, 100.0, "indicated airspeed at the center", shape=True),
        Parameter("width_mps", 5.0, 1.0, 30.0, "standard width of the band", shape=True),
    ),
    source="our form: a bump that no model of the table of curves can follow",
    what="The position error has a bump within a band of airspeed.",
    shows_in=STEPS_OF_AIRSPEED,  # the band is narrow, and a fast deceleration blurs it
    variant_of="static_source_change",
    changes=("impact_pressure", "static_pressure"),
    function=_apply_local_static_bump,
)


ENGINES = ("left", "right")
# Pa rad/s, rated power of the class
FULL = 40.0 * INCH_OF_MERCURY * 2575.0 * SUFFIXES["rpm"].factor
REFERENCE_SPEED = 130.0 * KNOT  # at which the stated error is meant
SLOWEST = 40.0 * KNOT  # below it the error stays: power over speed would grow without limit


def power_index(signals: Signals) -> Array:
    """Return manifold pressure times propeller speed over that at rated power [-], (n,).

    The value is the mean of the engines.
    """
    each = [
        signals[f"manifold_pressure_{side}"] * signals[f"propeller_speed_{side}"]
        for side in ENGINES
    ]
    return np.asarray(sum(each) / (len(each) * FULL))


def _apply_propwash_error(signals: Signals, sizes: Sizes) -> Signals:
    speed = np.maximum(air.calibrated_airspeed(signals["impact_pressure"].clip(min=0.0)), SLOWEST)
    # Thrust is power over speed, and the slipstream's pressure is proportional to thrust.
    return displaced(signals, sizes["pressure_pa"] * power_index(signals) * REFERENCE_SPEED / speed)


PROPWASH_ERROR = SensorEffect(
    name="propwash_error",
    part="static ports and line",
    parameters=(
        Parameter("pressure_pa", 40.0, -300.0, 300.0, "static error at rated power and 130 KIAS"),
    ),
    source="McCormick 1995, Aerodynamics, Aeronautics and Flight Mechanics, momentum theory: the "
    "slipstream's pressure goes with thrust over disk area, thrust with power over speed",
    what="The static pressure has an error that depends on engine power.",
    shows_in=POWER,
    changes=("impact_pressure", "static_pressure"),
    needs=tuple(
        f"{name}_{side}" for name in ("manifold_pressure", "propeller_speed") for side in ENGINES
    ),
    function=_apply_propwash_error,
)


SECOND_ORDER_LINE = SensorEffect(
    name="second_order_line",
    part="pitot line",
    parameters=(
        Parameter("lag_s", 0.4, 0.01, 3.0, "delay of a ramp, 2 damping / natural frequency"),
        Parameter("damping", 0.6, 0.2, 2.0, "damping ratio", shape=True),
    ),
    source="Doebelin 1990, Measurement Systems: pressure line and volume as a second-order system",
    what="The total-pressure line is late and oscillates.",
    shows_in=CHANGING_AIRSPEED,
    variant_of="pitot_lag",
    changes=("impact_pressure",),
    needs=("static_pressure",),
    function=_in_pitot_line(
        lambda signals, total, sizes: second_order(signals, total, sizes["lag_s"], sizes["damping"])
    ),
)


SLOW, FAST = 100.0 * KNOT, 160.0 * KNOT  # at which the two coefficients are meant


def _apply_static_source_change(signals: Signals, sizes: Sizes) -> Signals:
    impact = signals["impact_pressure"]
    share = (air.calibrated_airspeed(impact.clip(min=0.0)) - SLOW) / (FAST - SLOW)
    coefficient = (
        sizes["coefficient_at_100kt"] * (1.0 - share) + sizes["coefficient_at_160kt"] * share
    )
    return displaced(signals, coefficient * impact)


STATIC_SOURCE_CHANGE = SensorEffect(
    name="static_source_change",
    part="static ports and line",
    parameters=(
        Parameter(
            "coefficient_at_100kt",
            0.010,
            -0.1,
            0.1,
            "static error over impact pressure at 100 KIAS",
        ),
        Parameter(
            "coefficient_at_160kt", 0.005, -0.1, 0.1, "the same at 160 KIAS; linear in airspeed"
        ),
    ),
    source="Gracey 1980, NASA RP-1046: static-pressure errors of fuselage vents within some 0.05 "
    "q_c",
    what="The static port was moved, dented or painted: the position error is another curve.",
    shows_in=RANGE_OF_AIRSPEED,  # its coefficient has one size at each end of the airspeeds
    changes=("impact_pressure", "static_pressure"),
    function=_apply_static_source_change,
)


LOSS_SOURCE = (
    "Gracey 1980, NASA RP-1046: total-pressure error of tubes with nose shape and inclination"
)

TOTAL_PRESSURE_LOSS = SensorEffect(
    name="total_pressure_loss",
    part="pitot head",
    parameters=(
        Parameter("fraction", 0.01, -0.05, 0.15, "share of the impact pressure that is lost"),
    ),
    source=LOSS_SOURCE,
    what="The pitot tube reads too low at all speeds; the static pressure is right.",
    # A loss is in proportion to the impact pressure; GPS heights show that the static pressure is
    # right.
    shows_in=RANGE_OF_AIRSPEED,
    changes=("impact_pressure",),
    function=reads("impact_pressure", lambda pressure, sizes: pressure * (1.0 - sizes["fraction"])),
)

INCLINED_PITOT_LOSS = SensorEffect(
    name="inclined_pitot_loss",
    part="pitot head",
    parameters=(
        Parameter("loss_per_rad2", 1.0, -5.0, 10.0, "loss over impact pressure per square radian"),
    ),
    source=LOSS_SOURCE,
    what="The pitot tube reads too low at high angles of attack.",
    shows_in=RANGE_OF_AIRSPEED,  # the angle of attack is largest at the lowest airspeed
    variant_of="total_pressure_loss",
    changes=("impact_pressure",),
    needs=("angle_of_attack",),
    function=lambda signals, sizes: signals.with_channels(
        impact_pressure=signals["impact_pressure"]
        * (1.0 - sizes["loss_per_rad2"] * signals["angle_of_attack"] ** 2)
    ),
)


DRIFT_SOURCE = (
    "transducer data sheets: thermal zero shift some 0.01 % of full scale a kelvin, warm-up within "
    "an hour"
)


def _zero_drift(shift: Callable[[Signals, Sizes], Array]) -> SensorFunction:
    """The function of an impact transducer whose zero moves by `shift` [Pa], (n,)."""
    return lambda signals, sizes: signals.with_channels(
        impact_pressure=signals["impact_pressure"] + shift(signals, sizes)
    )


TIME_DRIFT = SensorEffect(
    name="time_drift",
    part="impact transducer",
    parameters=(
        Parameter(
            "rate_pa_per_min", 3.0, -30.0, 30.0, "zero shift per minute since the first sample"
        ),
    ),
    source=DRIFT_SOURCE,
    what="The impact-pressure transducer drifts steadily.",
    shows_in=EARLY_AND_LATE,
    for_whole_flight=True,
    changes=("impact_pressure",),
    function=_zero_drift(
        lambda signals, sizes: sizes["rate_pa_per_min"] * (elapsed(signals) / MINUTE)
    ),
)

TEMPERATURE_DRIFT = SensorEffect(
    name="temperature_drift",
    part="impact transducer",
    parameters=(
        Parameter(
            "shift_pa_per_k", 6.0, -60.0, 60.0, "zero shift per kelvin from the first sample"
        ),
    ),
    source=DRIFT_SOURCE,
    what="The impact-pressure transducer drifts with temperature.",
    shows_in=CHANGING_HEIGHT,
    for_whole_flight=True,
    changes=("impact_pressure",),
    needs=("total_temperature",),
    # The drift counts from the first sample: a zero is usually taken before the flight.
    function=_zero_drift(
        lambda signals, sizes: (
            sizes["shift_pa_per_k"]
            * (signals["total_temperature"] - signals["total_temperature"][0])
        )
    ),
)


WARM_UP_DRIFT = SensorEffect(
    name="warm_up_drift",
    part="impact transducer",
    parameters=(
        Parameter("shift_pa", 30.0, -300.0, 300.0, "zero shift after the warm-up"),
        Parameter("warm_up_s", 180.0, 5.0, 3600.0, "time constant of the warming", shape=True),
    ),
    source="transducer data sheets: warm-up shift; a lumped thermal mass warms exponentially",
    what="The impact-pressure transducer drifts at first and then settles.",
    shows_in=EARLY_AND_LATE,  # early means from the moment the system is switched on
    variant_of="time_drift",
    changes=("impact_pressure",),
    function=_zero_drift(
        lambda signals, sizes: sizes["shift_pa"] * -np.expm1(-elapsed(signals) / sizes["warm_up_s"])
    ),
)


WATER = 1000.0  # kg/m³


def _apply_water_in_line(signals: Signals, sizes: Sizes) -> Signals:
    static = signals["static_pressure"]
    total = first_order(signals, signals["impact_pressure"] + static, sizes["lag_s"])
    head = WATER * sizes["column_m"] * signals["specific_force_x"]
    return signals.with_channels(impact_pressure=total - static - head)


WATER_IN_LINE = SensorEffect(
    name="water_in_line",
    part="pitot line",
    parameters=(
        Parameter(
            "column_m",
            0.03,
            -0.3,
            0.3,
            "length of the water column along the airplane, tube ahead",
            defining=True,
        ),
        Parameter("lag_s", 0.8, 0.0, 20.0, "time constant of the restricted line"),
    ),
    source="hydrostatics, density times specific force times length; Gracey 1980, NASA RP-1046: "
    "water in lines",
    what="Water stands in the pitot line: the reading is late and changes with pitch and "
    "acceleration.",
    shows_in=CHANGING_AIRSPEED,
    neighbor="pitot_lag",
    changes=("impact_pressure",),
    needs=("static_pressure", "specific_force_x"),
    function=_apply_water_in_line,
)


ZERO_SOURCE = (
    "transducer data sheets: zero error up to some 0.1 % of full scale (13.8 kPa impact, 129 kPa "
    "static)"
)


IMPACT_ZERO_OFFSET = SensorEffect(
    name="impact_zero_offset",
    part="impact transducer",
    parameters=(Parameter("offset_pa", 15.0, -150.0, 150.0, "reading at zero impact pressure"),),
    source=ZERO_SOURCE,
    what="The impact-pressure transducer does not read zero at rest.",
    shows_in=RANGE_OF_AIRSPEED,  # a constant is the largest share of the impact pressure at the lowest airspeed
    changes=("impact_pressure",),
    function=reads("impact_pressure", lambda pressure, sizes: pressure + sizes["offset_pa"]),
)

STATIC_ZERO_OFFSET = SensorEffect(
    name="static_zero_offset",
    part="static transducer",
    parameters=(
        Parameter("offset_pa", 80.0, -500.0, 500.0, "reading above the true static pressure"),
    ),
    source=ZERO_SOURCE,
    what="The static-pressure transducer reads too high or too low by a constant.",
    shows_in=CHANGING_HEIGHT,
    changes=("static_pressure",),
    function=reads("static_pressure", lambda pressure, sizes: pressure + sizes["offset_pa"]),
)


SCALE_SOURCE = "transducer data sheets: span errors of 0.05 to 0.5 % (classes, not one maker)"

IMPACT_PRESSURE_SCALE = SensorEffect(
    name="impact_pressure_scale",
    part="impact transducer",
    parameters=(Parameter("scale", 0.005, -0.1, 0.1, "impact pressure too large by this share"),),
    source=SCALE_SOURCE,
    what="The impact-pressure transducer has a wrong scale; in a log it is a total-pressure loss.",
    shows_in=RANGE_OF_AIRSPEED,
    one_model_with="total_pressure_loss",
    changes=("impact_pressure",),
    function=reads("impact_pressure", lambda pressure, sizes: (1.0 + sizes["scale"]) * pressure),
)

STATIC_PRESSURE_SCALE = SensorEffect(
    name="static_pressure_scale",
    part="static transducer",
    parameters=(Parameter("scale", 0.002, -0.05, 0.05, "static pressure too large by this share"),),
    source=SCALE_SOURCE,
    what="The static-pressure transducer has a wrong scale.",
    shows_in=CHANGING_HEIGHT,
    for_whole_flight=True,
    changes=("static_pressure",),
    function=reads("static_pressure", lambda pressure, sizes: (1.0 + sizes["scale"]) * pressure),
)
